"""The thread that works on the queued diagnoses, one after the other."""

from __future__ import annotations

import json
import logging
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy.exc import SQLAlchemyError

from omnimate.service.jobs.diagnosis_process import REPORT_PERIOD, diagnosing
from omnimate.service.jobs.housekeeping import keep_house
from omnimate.service.jobs.queue import LEASE, claim_job, find_job, finish_job, has_queued, job_of, job_view
from omnimate.service.recording_zip import unpack
from omnimate.service.store.tables import RecordingRow

if TYPE_CHECKING:
    from omnimate.service.event_stream import EventStream
    from omnimate.service.robot.session_reporter import SessionReporter
    from omnimate.service.store.database import Database

LOOK_PERIOD = 1.0  # [s] between two looks for a queued diagnosis
_log = logging.getLogger(__name__)


class Worker:
    """The thread of one service; several services may share a database and its queue."""

    def __init__(
        self,
        database: Database,
        events: EventStream,
        reporter: SessionReporter,
        instance: str,
        unpacked_limit: int,
    ) -> None:
        self._database, self._events, self._reporter = database, events, reporter
        self._instance, self._unpacked_limit = instance, unpacked_limit
        self._ending, self._wake = threading.Event(), threading.Event()
        self._renewed = 0.0
        self._thread = threading.Thread(target=self._run, name="jobs", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread; a diagnosis that it works on is queued again."""
        self._ending.set()
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def wake(self) -> None:
        """Have the thread look for a queued diagnosis at once."""
        self._wake.set()

    def _run(self) -> None:
        while not self._ending.is_set():
            try:
                for session in keep_house(self._database):
                    self._reporter.announce(session)
                job_id = self._claim()
                if job_id is not None:
                    self._diagnose(job_id)
                    continue
            except SQLAlchemyError:
                _log.exception("the database did not answer; it is tried again")
            self._wake.wait(LOOK_PERIOD)
            self._wake.clear()

    def _claim(self) -> str | None:
        with self._database.reading() as db:
            if not has_queued(db):
                return None
        with self._database.writing() as db:
            return claim_job(db, self._instance)

    def _diagnose(self, job_id: str) -> None:
        """Diagnose in another process, and keep the outcome."""
        self._publish(job_id)
        with tempfile.TemporaryDirectory() as place:
            folders = self._unpack(job_id, Path(place))
            with diagnosing(folders) as process:
                self._finish(job_id, process.outcome(lambda message: self._renew(job_id, message)))
        self._publish(job_id)

    def _unpack(self, job_id: str, place: Path) -> list[tuple[str, str]]:
        """Return the name of each recording and the folder into which it was unpacked."""
        folders = []
        with self._database.reading() as db:
            for recording_id in json.loads(find_job(db, job_id).recordings):
                row = db.get(RecordingRow, recording_id)
                if row is not None:
                    folder = place / row.id
                    folder.mkdir()
                    folders.append((row.name, str(unpack(row.content, folder, self._unpacked_limit))))
        return folders

    def _renew(self, job_id: str, message: dict[str, Any]) -> bool:
        """Renew the lease and note the progress; return whether the diagnosis is still wanted."""
        now = time.monotonic()
        if now - self._renewed < REPORT_PERIOD:
            return True
        self._renewed = now
        if self._ending.is_set():
            return False
        with self._database.writing() as db:
            row = job_of(db, job_id, self._instance)
            if row is None:
                return False
            row.lease = time.time() + LEASE
            if message:
                row.progress, row.doing = message["progress"], message["doing"][:200]
        if message:
            self._publish(job_id)
        return True

    def _finish(self, job_id: str, outcome: dict[str, Any] | None) -> None:
        with self._database.writing() as db:
            row = job_of(db, job_id, self._instance)
            if row is not None:
                finish_job(row, outcome)

    def _publish(self, job_id: str) -> None:
        with self._database.reading() as db:
            self._events.publish("job", job_view(find_job(db, job_id)).model_dump())
