"""Batches as jobs: their thread, their process, and its stored outcome."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import select

from omnimate.fleet.errors import FleetError
from omnimate.fleet.report_store import read_report
from omnimate.service.errors import StateError
from omnimate.service.fleets.findings import note_findings
from omnimate.service.fleets.models import Batch, BatchStart
from omnimate.service.jobs.process import running
from omnimate.service.jobs.queue import ENDED_STATES, queue_job
from omnimate.service.jobs.worker import Worker
from omnimate.service.store.tables import BatchRow, FleetRow, find_row

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager
    from pathlib import Path

    from sqlalchemy.orm import Session

    from omnimate.fleet.batch.run import Workers
    from omnimate.service.event_stream import EventStream
    from omnimate.service.jobs.process import JobProcess
    from omnimate.service.settings import Settings
    from omnimate.service.store.database import Database
    from omnimate.service.store.recordings import FleetStores
    from omnimate.service.store.tables import JobRow

SHOWN_FAILURES = 50
NOT_ENDED: dict[str, Any] = {"done": None, "known": None, "failures": [], "night": None, "note": None}
WORKING = 0.95  # of a batch's progress; the rest is judging


def add_batch(db: Session, fleet: str, start: BatchStart) -> JobRow:
    """Queue a batch of a fleet; NotFoundError where there is no fleet of this name."""
    find_row(db, FleetRow, fleet)
    asked = {"day": start.day, "diagnose": start.diagnose}
    return queue_job(db, BatchRow, fleet=fleet, asked=asked, priority=start.priority, recordings=[])


def require_no_batch(db: Session, fleet: str) -> None:
    """Refuse, by StateError, what a batch of the fleet that has not ended would undo, or see half done."""
    unfinished = (BatchRow.fleet == fleet) & BatchRow.state.not_in(ENDED_STATES)
    row = db.scalars(select(BatchRow).where(unfinished).limit(1)).first()
    if row is not None:
        raise StateError(
            f"batch {row.id} of this fleet is {row.state}; wait until it has ended, or cancel it"
        )


def batch_view(row: JobRow) -> Batch:
    """Return a batch as clients see it."""
    return Batch.of(row, **(row.asked or {}), **(NOT_ENDED | (row.summary or {})))


class BatchWorker(Worker):
    """The thread that processes the recordings of fleets."""

    table = BatchRow
    view = staticmethod(batch_view)

    def __init__(
        self, database: Database, events: EventStream, settings: Settings, stores: FleetStores
    ) -> None:
        super().__init__(database, events, settings.instance)
        self._settings, self._stores = settings, stores

    def start_job(self, job_id: str, _place: Path) -> AbstractContextManager[JobProcess]:
        """Return the process of a batch."""
        from omnimate.fleet.batch.run import Workers

        with self._database.reading() as db:
            row = find_row(db, BatchRow, job_id)
        assert row.fleet is not None
        asked = row.asked or {}
        store, results = self._stores.recordings_of(row.fleet).url, self._stores.results_of(row.fleet).url
        workers = Workers(self._settings.jobs, self._settings.scheduler)
        return running("batch", run_fleet_batch, store, results, asked["day"], asked["diagnose"], workers)

    def store_result(self, db: Session, row: JobRow, outcome: dict[str, Any]) -> None:
        """Store the outcome of a batch, and the findings of its report with the messages about them."""
        report = outcome.pop("report", None)
        row.summary = outcome
        if report is not None:
            assert row.fleet is not None
            note_findings(db, row.fleet, report)


def run_fleet_batch(
    report_progress: Callable[[float, str], None],
    store: str,
    results: str,
    day: str | None,
    diagnosed: bool,
    workers: Workers,
) -> dict[str, Any]:
    """Process a fleet's recordings and judge the day; return what was done, and the daily report.

    Recordings of all dates are processed where `day` is None; whole diagnoses are made where triage asks for
    them and `diagnosed` is set.
    """
    from omnimate.fleet.batch.files import open_files
    from omnimate.fleet.batch.run import run_batch
    from omnimate.fleet.judge import judge_day

    def worked(done: int, total: int) -> None:
        report_progress(WORKING * done / total, f"recording {done} of {total}")

    def read(done: int, total: int) -> None:
        report_progress(WORKING, f"judging robots and floor, recording {done} of {total}")

    batch = run_batch(store, results, day=day, diagnosed=diagnosed, workers=workers, progress=worked)
    failures = [
        {"robot": stored.robot, "day": stored.day, "recording": stored.name, "problem": why}
        for stored, why in sorted(batch.failed + batch.unreadable)[:SHOWN_FAILURES]
    ]
    outcome = {"done": batch.done, "known": batch.known, "failures": failures, "night": None, "note": None}
    try:
        files = open_files(results)
        judged = judge_day(files, day, read).day
        return outcome | {"night": judged, "report": read_report(files, judged)}
    except FleetError as error:
        return outcome | {"note": str(error)}
