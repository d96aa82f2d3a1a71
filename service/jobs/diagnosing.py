"""Diagnoses as jobs: what their process does, and what is kept of it."""

from __future__ import annotations

import json
import logging
import signal
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from omnimate.service.errors import NotFoundError
from omnimate.service.jobs.process import running
from omnimate.service.jobs.queue import find_job, job_view
from omnimate.service.store.tables import RecordingRow
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from multiprocessing.connection import Connection

    from sqlalchemy.orm import Session

    from omnimate.service.jobs.models import Job
    from omnimate.service.jobs.process import JobProcess
    from omnimate.service.store.database import Database
    from omnimate.service.store.recordings import RecordingStore
    from omnimate.service.store.tables import JobRow

_log = logging.getLogger(__name__)


class Diagnosing:
    """The diagnoses among the jobs.

    Args:
        recordings: The store of the recordings.
    """

    kind: Final = "diagnose"

    def __init__(self, recordings: RecordingStore) -> None:
        self._recordings = recordings

    def start(self, database: Database, job_id: str, place: Path) -> AbstractContextManager[JobProcess]:
        """Return the process of a job, which works in the folder `place`."""
        with database.reading() as db:
            wanted = find_job(db, job_id).recordings
            rows = [row for recording in wanted if (row := db.get(RecordingRow, recording)) is not None]
        folders = []
        for row in rows:
            folder = place / row.id
            folder.mkdir()
            with suppress(NotFoundError):  # deleted meanwhile
                folders.append((row.name, str(self._recordings.unpack(row, folder))))
        return running(run_diagnosis, folders)

    def keep(self, _db: Session, row: JobRow, outcome: dict[str, Any]) -> None:
        """Keep the result of a job that is done."""
        row.verdict, row.says = outcome["verdict"], outcome["says"]
        row.result, row.report = outcome["result"], outcome["report"]

    def view(self, row: JobRow) -> Job:
        """Return a job as clients see it."""
        return job_view(row)


def run_diagnosis(parent: Connection, folders: list[tuple[str, str]]) -> None:
    """Diagnose recordings and report to the parent process: the progress, and at the end the result.

    Args:
        parent: The connection to the parent process.
        folders: Name and folder of each recording.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides when this process ends
    from omnimate.files.recordings.folder import load_recording
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
