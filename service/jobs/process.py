"""A job in a process of its own, so that it may use a core and a gigabyte, and crash without the service."""

from __future__ import annotations

import logging
import multiprocessing
import signal
import traceback
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

REPORT_PERIOD = 0.5  # [s] between two reports of progress
_log = logging.getLogger(__name__)


class JobProcess:
    """A job that runs in another process, as its parent process uses it."""

    def __init__(self, process: BaseProcess, connection: Connection) -> None:
        self._process, self._connection = process, connection

    def outcome(self, go_on: Callable[[dict[str, Any]], bool]) -> dict[str, Any] | None:
        """Follow the process to its end; return its last message.

        Args:
            go_on: Called every `REPORT_PERIOD` with the last report of progress, or with an empty dictionary;
                the process is given up when it returns False.

        Returns:
            The result or `{"error": sentence}` as the process sent it, `{"died": reason}` where the process
            ended without a message, None where it was given up.
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
                    return self._exit_message()
                if not go_on(message):
                    return None
        except EOFError:
            self._process.join(1.0)
            return self._exit_message()

    def _exit_message(self) -> dict[str, Any]:
        return {"died": f"its process ended with code {self._process.exitcode}"}


def _run(parent: Connection, noun: str, work: Callable[..., dict[str, Any]], *arguments: object) -> None:
    """Work in the job's process, and send the progress and at the end the result or `{"error": sentence}`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when this process ends

    def report_progress(part: float, doing: str) -> None:
        parent.send({"progress": part, "doing": doing})

    try:
        parent.send(work(report_progress, *arguments))
    except OmnimateError as error:
        parent.send({"error": str(error)})
    except Exception as error:  # noqa: BLE001  # the job must fail with a reason, whatever its error
        sentence = f"an error in the {noun} itself: {type(error).__name__}: {error}"
        parent.send({"error": sentence, "traceback": traceback.format_exc()})


@contextmanager
def running(noun: str, work: Callable[..., dict[str, Any]], *arguments: object) -> Iterator[JobProcess]:
    """Start a process for a job, and end it with the block.

    Args:
        noun: What the job is, for messages.
        work: Returns the result. It reports by its first argument which part is done, and what is done now.
        *arguments: Its other arguments.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe()
    # Not a daemon: those may not start processes, which a batch with several workers does.
    process = context.Process(target=_run, args=(sender, noun, work, *arguments))
    process.start()
    sender.close()
    try:
        yield JobProcess(process, receiver)
    finally:
        process.kill()
        process.join()
        receiver.close()
