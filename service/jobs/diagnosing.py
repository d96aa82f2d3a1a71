"""Diagnoses as jobs: their thread, what their process does, and what is stored of it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from omnimate.service.errors import NotFoundError, ServiceError
from omnimate.service.jobs.process import running
from omnimate.service.jobs.queue import Job
from omnimate.service.jobs.worker import Worker
from omnimate.service.store.tables import DiagnosisRow, RecordingRow, find_row

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager
    from pathlib import Path

    from sqlalchemy.orm import Session

    from omnimate.service.event_stream import EventStream
    from omnimate.service.jobs.process import JobProcess
    from omnimate.service.store.database import Database
    from omnimate.service.store.recordings import RecordingStore
    from omnimate.service.store.tables import JobRow


class DiagnosisWorker(Worker):
    """The thread that diagnoses recordings."""

    table = DiagnosisRow
    view = staticmethod(Job.of)

    def __init__(
        self,
        database: Database,
        events: EventStream,
        instance: str,
        recordings: RecordingStore,
    ) -> None:
        super().__init__(database, events, instance)
        self._recordings = recordings

    def start_job(self, job_id: str, place: Path) -> AbstractContextManager[JobProcess]:
        """Return the process of a job; ServiceError where one of the recordings was deleted meanwhile."""
        with self._database.reading() as db:
            wanted = find_row(db, DiagnosisRow, job_id).recordings
        folders = []
        for recording_id in wanted:
            folders.append(self._unpack(recording_id, place))
            self._renew(job_id, {})  # many large ones take longer than a lease
        return running("diagnosis", run_diagnosis, str(place), folders)

    def _unpack(self, recording_id: str, place: Path) -> tuple[str, str]:
        """Unpack a recording into a folder of `place`; return its name, and the folder within `place`."""
        folder = place / recording_id
        folder.mkdir()
        try:
            with self._database.reading() as db:
                row = find_row(db, RecordingRow, recording_id)
            unpacked = self._recordings.unpack(row, folder)
        except NotFoundError as error:
            raise ServiceError(
                f"recording {recording_id} was deleted before it was diagnosed; upload it again, or diagnose "
                "the others without it"
            ) from error
        return row.name, str(unpacked.relative_to(place))

    def store_result(self, _db: Session, row: JobRow, outcome: dict[str, Any]) -> None:
        """Store the result of a job that is done."""
        row.verdict, row.says = outcome["verdict"], outcome["says"]
        row.result, row.report = outcome["result"], outcome["report"]


def run_diagnosis(
    report_progress: Callable[[float, str], None], place: str, folders: list[tuple[str, str]]
) -> dict[str, Any]:
    """Diagnose recordings; return the result's columns."""
    from omnimate.mismatch import diagnose
    from omnimate.mismatch.report.page import render
    from omnimate.service.store.recordings import read_relative

    recordings = [read_relative(place, folder, name)[0] for name, folder in folders]
    diagnosis = diagnose(recordings, progress=lambda done, total, doing: report_progress(done / total, doing))
    return {
        "verdict": diagnosis.verdict,
        "says": diagnosis.says,
        "result": json.dumps(diagnosis.as_json()),
        "report": render(diagnosis),
    }
