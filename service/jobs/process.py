"""A job in its own process, which may use a core and a gigabyte, and may die."""

from __future__ import annotations

import multiprocessing
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

REPORT_PERIOD = 0.5  # [s] between two reports of progress


class JobProcess:
    """A job that runs in another process, as its parent sees it."""

    def __init__(self, process: BaseProcess, connection: Connection) -> None:
        self._process, self._connection = process, connection

    def outcome(self, go_on: Callable[[dict[str, Any]], bool]) -> dict[str, Any] | None:
        """Follow the process to its end; return its last message.

        Args:
            go_on: Called every `REPORT_PERIOD` with the last report of progress, or with an empty dictionary;
                the process is given up when it returns False.

        Returns:
            The result or `{"error": sentence}` as the process sent it, `{"died": reason}` where the process
            ended without a word, None where it was given up.
        """
        try:
            while True:
                message: dict[str, Any] = {}
                if self._connection.poll(REPORT_PERIOD):
                    message = self._connection.recv()
                    if "progress" not in message:
                        return message
                elif not self._process.is_alive():
                    return self._death()
                if not go_on(message):
                    return None
        except EOFError:
            self._process.join(1.0)
            return self._death()

    def _death(self) -> dict[str, Any]:
        return {"died": f"its process ended with code {self._process.exitcode}"}


@contextmanager
def running(target: Callable[..., None], *arguments: object) -> Iterator[JobProcess]:
    """Start a process for a job, and end it with the block.

    Args:
        target: What it runs: its first argument is the connection to the parent process, to which it sends
            `{"progress": part, "doing": words}`, and at the end the result or `{"error": sentence}`.
        *arguments: Its other arguments.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    # Not a daemon: those may not start processes, which a batch with several workers does.
    process = context.Process(target=target, args=(theirs, *arguments))
    process.start()
    theirs.close()
    try:
        yield JobProcess(process, ours)
    finally:
        process.kill()
        process.join()
        ours.close()
