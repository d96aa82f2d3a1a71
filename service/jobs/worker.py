"""A thread that works on the queued jobs of one kind, one after the other."""

from __future__ import annotations

import logging
import tempfile
import time
from abc import ABC, abstractmethod
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from sqlalchemy.exc import SQLAlchemyError

from omnimate.service.jobs.process import REPORT_PERIOD
from omnimate.service.jobs.queue import LEASE, claim_job, finish_job, has_queued, job_of
from omnimate.service.store.tables import find_row
from omnimate.service.threads import RepeatingThread
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from pydantic import BaseModel
    from sqlalchemy.orm import Session

    from omnimate.service.event_stream import EventStream
    from omnimate.service.jobs.process import JobProcess
    from omnimate.service.store.database import Database
    from omnimate.service.store.tables import JobRow

_log = logging.getLogger(__name__)


class Worker(RepeatingThread, ABC):
    """The thread of one service; several services may share a database and its queue.

    A job that it works on when it is closed is queued again.
    """

    table: ClassVar[type[JobRow]]  # of its kind of jobs

    def __init__(self, database: Database, events: EventStream, instance: str) -> None:
        super().__init__(f"jobs: {self.table.noun()}")
        self._database, self._events, self._instance = database, events, instance
        self._renewed = 0.0

    @abstractmethod
    def start_job(self, job_id: str, place: Path) -> AbstractContextManager[JobProcess]:
        """Return the process of a job, which works in the folder `place`."""

    @abstractmethod
    def store_result(self, db: Session, row: JobRow, outcome: dict[str, Any]) -> None:
        """Store the result of a job that is done."""

    @abstractmethod
    def view(self, row: JobRow) -> BaseModel:
        """Return a job as clients see it."""

    def work(self) -> bool:
        """Work on the next queued job; return whether there was one."""
        job_id = self._claim()
        if job_id is not None:
            self._work(job_id)
        return job_id is not None

    def _claim(self) -> str | None:
        with self._database.reading() as db:
            if not has_queued(db, self.table):
                return None
        with self._database.writing() as db:
            return claim_job(db, self._instance, self.table)

    def _work(self, job_id: str) -> None:
        """Work in another process, and store the outcome."""
        self._publish(job_id)
        with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
            try:
                process = stack.enter_context(self.start_job(job_id, Path(folder)))
            except SQLAlchemyError:  # the job is taken up again when the database is back
                raise
            except Exception as error:  # noqa: BLE001  # the job must fail with a reason, whatever its error
                self._finish(job_id, {"error": self._reason(error)})
            else:
                self._finish(job_id, process.outcome(lambda message: self._renew(job_id, message)))
        self._publish(job_id)

    def _reason(self, error: Exception) -> str:
        """Return why a job could not start."""
        if isinstance(error, OmnimateError):
            return str(error)
        noun = self.table.noun()
        _log.error("a %s could not start", noun, exc_info=error)
        return f"the {noun} could not start: {type(error).__name__}; the log of the service says more"

    def _renew(self, job_id: str, message: dict[str, Any]) -> bool:
        """Renew the lease and note the progress; return whether the job is still wanted."""
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
            if row is not None and finish_job(row, outcome) and outcome is not None:
                self.store_result(db, row, outcome)

    def _publish(self, job_id: str) -> None:
        with self._database.reading() as db:
            view = self.view(find_row(db, self.table, job_id))
            self._events.publish("job", view.model_dump())
