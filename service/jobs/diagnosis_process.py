"""A diagnosis in its own process, which may use a core and a gigabyte, and may die."""

from __future__ import annotations

import json
import logging
import multiprocessing
import signal
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from multiprocessing.connection import Connection
    from multiprocessing.process import BaseProcess

REPORT_PERIOD = 0.5  # [s] between two reports of progress
_log = logging.getLogger(__name__)


class DiagnosisProcess:
    """A diagnosis that runs in another process, as its parent sees it."""

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
def diagnosing(folders: list[tuple[str, str]]) -> Iterator[DiagnosisProcess]:
    """Start a process that diagnoses recordings, and end it with the block.

    Args:
        folders: Name and folder of each recording.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=run_diagnosis, args=(theirs, folders), daemon=True)
    process.start()
    theirs.close()
    try:
        yield DiagnosisProcess(process, ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def run_diagnosis(parent: Connection, folders: list[tuple[str, str]]) -> None:
    """Diagnose recordings and report to the parent process: the progress, and at the end the result.

    Args:
        parent: The connection to the parent process.
        folders: Name and folder of each recording.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when this process ends
    from omnimate.logs.folder import load_recording
    from omnimate.mismatch import diagnose
    from omnimate.mismatch.report import render

    def report_progress(done: int, total: int, doing: str) -> None:
        parent.send({"progress": done / total, "doing": doing})

    try:
        recordings = [replace(load_recording(Path(folder)), source=name) for name, folder in folders]
        diagnosis = diagnose(recordings, progress=report_progress)
        parent.send(
            {
                "verdict": diagnosis.verdict,
                "says": diagnosis.says,
                "result": json.dumps(diagnosis.as_json()),
                "report": render(diagnosis),
            }
        )
    except OmnimateError as error:
        parent.send({"error": str(error)})
    except Exception as error:  # noqa: BLE001  # the job must fail with a reason, whatever happened
        _log.exception("a diagnosis failed")
        parent.send({"error": f"an error in the diagnosis itself: {type(error).__name__}: {error}"})
