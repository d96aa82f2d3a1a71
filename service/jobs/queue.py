"""The queue of diagnoses and batches: added, cancelled, claimed, given back, finished; what is overdue."""

from __future__ import annotations

import hashlib
import json
import time
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field
from sqlalchemy import delete, func, select, update

from omnimate import __version__
from omnimate.service.errors import StateError, TooManyError
from omnimate.service.store.tables import (
    AnswerRow,
    DiagnosisRow,
    JobRow,
    RecordingRow,
    SessionRow,
    find_row,
    lease_ended,
)
from omnimate.service.umbmark.models import Id, RequestModel, RowModel
from omnimate.service.umbmark.sessions import OPEN_STATES, interrupt_orphans

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session

    from omnimate.service.store.database import Database


ANSWERS_KEPT = 86400.0  # [s] in which a request with an Idempotency-Key may be repeated
JobState = Literal["queued", "running", "done", "failed", "cancelled"]


def _each_once(recordings: list[str]) -> list[str]:
    """Return recordings of which none is given twice; ValueError otherwise."""
    for recording in recordings:
        if recordings.count(recording) > 1:
            raise ValueError(f"recording {recording} is given twice; expected each of them once")
    return recordings


class DiagnosisStart(RequestModel):
    """The recordings that are diagnosed together; they are all of one robot."""

    recordings: Annotated[
        list[Id],
        Field(min_length=1, max_length=50, json_schema_extra={"uniqueItems": True}),
        AfterValidator(_each_once),
    ]


class Job(RowModel):
    """A diagnosis that waits, is running, or has ended."""

    id: str
    kind: Literal["diagnose"] = "diagnose"
    recordings: list[str]
    state: JobState
    progress: float
    doing: str
    verdict: str | None
    says: str | None
    error: str | None
    attempts: int
    created: float
    changed: float


LEASE = 20.0  # [s] after which a service that does not renew its lease is considered dead
MAX_ATTEMPTS = 3
MAX_UNFINISHED = 50  # diagnoses of one key, about half an hour of work: then others have a turn
ENDED_STATES = ("done", "failed", "cancelled")


def add_job(db: Session, recordings: Sequence[str], caller: str) -> JobRow:
    """Queue a diagnosis of recordings; one that this version has made already is done at once.

    Raises:
        NotFoundError: one of the recordings does not exist.
        TooManyError: too many diagnoses of the caller wait.
    """
    rows = [find_row(db, RecordingRow, recording) for recording in recordings]
    content = _content(rows)
    same = select(DiagnosisRow).where(JobRow.content == content, JobRow.state == "done").limit(1)
    known = None if content is None else db.scalars(same).first()
    columns = {"recordings": list(recordings), "caller": caller, "content": content}
    if known is not None:
        found = {name: getattr(known, name) for name in ("verdict", "says", "result", "report")}
        return queue_job(db, DiagnosisRow, **columns, **found, state="done", progress=1.0, doing="")
    mine = (DiagnosisRow.caller == caller) & DiagnosisRow.state.not_in(ENDED_STATES)
    if (db.scalar(select(func.count(DiagnosisRow.id)).where(mine)) or 0) >= MAX_UNFINISHED:
        raise TooManyError(
            f"{MAX_UNFINISHED} diagnoses of this key wait or run; ask again when some have ended"
        )
    return queue_job(db, DiagnosisRow, **columns)


def _content(recordings: Sequence[RecordingRow]) -> str | None:
    """Return a hash of all that a diagnosis depends on; None where a recording has no hash."""
    named = [(row.name, row.sha256) for row in recordings]
    if any(digest is None for _, digest in named):
        return None
    return hashlib.sha256(json.dumps([__version__, named]).encode()).hexdigest()


def queue_job(db: Session, table: type[JobRow], **columns: Any) -> JobRow:  # noqa: ANN401  # of `JobRow`
    """Add a job with columns that differ from those of every new job, and return it."""
    now = time.time()
    row = table(created=now, changed=now, **columns)
    db.add(row)
    db.flush()
    return row


def cancel_job(row: JobRow) -> JobRow:
    """Cancel a locked job; its worker stops when it renews the lease. StateError where it has ended."""
    if row.state in ENDED_STATES:
        raise StateError(f"{row.noun()} {row.id} is {row.state} already")
    row.state, row.doing, row.changed = "cancelled", "", time.time()
    return row


def has_queued(db: Session, table: type[JobRow]) -> bool:
    """Return whether a job of a kind waits to be claimed."""
    return db.scalar(select(table.id).where(table.state == "queued").limit(1)) is not None


def claim_job(db: Session, instance: str, table: type[JobRow] = DiagnosisRow) -> str | None:
    """Claim the oldest of the most urgent queued jobs; return its id, or None where another was faster."""
    row = db.scalars(
        select(table)
        .where(table.state == "queued")
        .order_by(table.priority.desc(), table.created)
        .limit(1)
        .with_for_update(skip_locked=True)
    ).first()
    if row is None:
        return None
    now = time.time()
    row.state, row.owner, row.attempts = "running", instance, row.attempts + 1
    row.changed, row.lease = now, now + LEASE
    row.doing = "reading the recordings"
    return row.id


def job_of(db: Session, job_id: str, instance: str) -> JobRow | None:
    """Return a job, locked, if a service still works on it; None where it was cancelled or taken over."""
    row = db.get(JobRow, job_id, with_for_update=True)
    if row is None or row.state != "running" or row.owner != instance:
        return None
    return row


def finish_job(row: JobRow, outcome: dict[str, Any] | None) -> bool:
    """Note how a job ended; return whether it is done, so that its result has to be stored."""
    row.changed = time.time()
    if outcome is None:
        row.attempts -= 1  # however often services are stopped, the job is not to blame
        give_back(row, "the service was stopped")
    elif "died" in outcome:
        give_back(row, outcome["died"])
    elif "error" in outcome:
        row.state, row.error, row.doing = "failed", outcome["error"], ""
    else:
        row.state, row.progress, row.doing = "done", 1.0, ""
    return row.state == "done"


def give_back(row: JobRow, reason: str) -> None:
    """Queue a job again, or let it fail after several attempts."""
    row.owner = row.lease = None
    row.changed = time.time()
    if row.attempts >= MAX_ATTEMPTS:
        row.state, row.error, row.doing = "failed", f"given up after {row.attempts} attempts: {reason}", ""
    else:
        row.state, row.doing = "queued", f"waiting again: {reason}"


def expire_sessions_and_requeue_jobs(database: Database) -> list[str]:
    """Expire sessions, queue jobs of dead services again; return the ids of interrupted sessions."""
    now = time.time()
    _give_back_orphans(database, now)
    with database.writing() as db:
        orphans = interrupt_orphans(db)
        unused = SessionRow.state.in_(OPEN_STATES) & (SessionRow.state != "driving")
        db.execute(update(SessionRow).where(unused & (SessionRow.expires < now)).values(state="expired"))
        db.execute(delete(AnswerRow).where(AnswerRow.created < now - ANSWERS_KEPT))
    return orphans


def _give_back_orphans(database: Database, now: float) -> None:
    """Queue the jobs again whose service has died."""
    orphaned = (JobRow.state == "running") & lease_ended(JobRow.lease, now, LEASE)
    with database.reading() as db:
        if db.scalar(select(JobRow.id).where(orphaned).limit(1)) is None:
            return
    with database.writing() as db:
        for row in db.scalars(select(JobRow).where(orphaned).with_for_update()):
            give_back(row, "the service that worked on it has ended")
