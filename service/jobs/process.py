"""A job in a process of its own, so that it may use a core and a gigabyte, and crash without the service."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import threading
import traceback
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from omnimate.service.processes import process_context
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

REPORT_PERIOD = 0.5  # [s] between two reports of progress
# Share of the machine's memory that a job may take: where that is too little, it fails, and not the service.
# A diagnosis takes 35 kB a sample (`python -m studies.speed.diagnose_speed`).
MEMORY_SHARE = 0.75
NICENESS = 10  # of a job's process, so that the service and its robot are served first
_log = logging.getLogger(__name__)


class JobProcess:
    """A job that runs in another process, as its parent process uses it."""

    def __init__(self, process: BaseProcess, connection: Connection) -> None:
        self._process, self._connection = process, connection

    def outcome(self, go_on: Callable[[dict[str, Any]], bool]) -> dict[str, Any] | None:
        """Follow the process to its end; return its last message.

        `go_on` is called every `REPORT_PERIOD` with the last report of progress, or with an empty dictionary;
        the process is given up when it returns False.

        Returns:
            The result or `{"error": sentence}` as the process sent it, with `"limit": "memory"` where its
            memory was not enough; `{"died": reason}` where the process ended without a message, None where
            it was given up.
        """
        try:
            while True:
                message: dict[str, Any] = {}
                if self._connection.poll(REPORT_PERIOD):
                    message = self._connection.recv()
                    if "traceback" in message:  # logged here, where the log's format is known
                        _log.error("%s\n%s", message["error"], message.pop("traceback"))
                    if "progress" not in message:
                        return message
                elif not self._process.is_alive():
                    break
                if not go_on(message):
                    return None
        except EOFError:
            self._process.join(1.0)
        return {"died": f"its process ended with code {self._process.exitcode}"}


def _limit(memory: int | None, niceness: int) -> str:
    """Limit the memory of this process, and have it give way to others; return what is too much."""
    try:
        import resource
    except ImportError:  # Windows has no such limits
        return "more memory than there is"
    memory = memory or int(MEMORY_SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    _, most = resource.getrlimit(resource.RLIMIT_DATA)  # what the service itself was given
    memory = memory if most == resource.RLIM_INFINITY else min(memory, most)
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    os.nice(niceness)
    return f"more than {memory / 1e6:.0f} MB of memory"


def _end_with_parent() -> None:
    """End this process as soon as the service has ended, as by SIGKILL; nobody takes its result any more."""
    service = multiprocessing.parent_process()
    assert service is not None
    service.join()
    os._exit(1)


def _run(
    parent: Connection,
    noun: str,
    memory: int | None,
    niceness: int,
    work: Callable[..., dict[str, Any]],
    *arguments: object,
) -> None:
    """Work in the job's process, and send the progress and at the end the result or `{"error": sentence}`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when this process ends
    threading.Thread(target=_end_with_parent, name="parent", daemon=True).start()
    too_much = _limit(memory, niceness)

    def report_progress(part: float, doing: str) -> None:
        parent.send({"progress": part, "doing": doing})

    try:
        parent.send(work(report_progress, *arguments))
    except OmnimateError as error:
        parent.send({"error": str(error)})
    except MemoryError:
        parent.send({"error": f"this {noun} takes {too_much}", "limit": "memory"})
    except Exception as error:  # noqa: BLE001  # the job must fail with a reason, whatever its error
        sentence = f"an error in the {noun} itself: {type(error).__name__}: {error}"
        parent.send({"error": sentence, "traceback": traceback.format_exc()})


@contextmanager
def running(
    noun: str,
    work: Callable[..., dict[str, Any]],
    *arguments: object,
    memory: int | None = None,
    niceness: int = NICENESS,
) -> Iterator[JobProcess]:
    """Start a process for a job, which messages call by its noun, and end it with the block.

    `work` returns the result; it reports by its first argument which part is done, and what is done now. It
    may take `MEMORY_SHARE` of the machine's memory, or `memory` [bytes], and gives way to other processes by
    its niceness, 0 to 19.
    """
    context = process_context()
    receiver, sender = context.Pipe()
    # Not a daemon: those may not start processes, which a batch with several workers does.
    process = context.Process(target=_run, args=(sender, noun, memory, niceness, work, *arguments))
    process.start()
    sender.close()
    try:
        yield JobProcess(process, receiver)
    finally:
        process.kill()
        process.join()
        receiver.close()
