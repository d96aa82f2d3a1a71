"""The queue of diagnoses in the database: added, found, cancelled, claimed, given back, finished."""

from __future__ import annotations

import json
import secrets
import time
from typing import TYPE_CHECKING, Any

from sqlalchemy import select

from omnimate.service.errors import NotFoundError, StateError
from omnimate.service.jobs.models import Job
from omnimate.service.store.tables import JobRow, RecordingRow

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sqlalchemy.orm import Session

LEASE = 20.0  # [s] after which a service that does not renew its lease is taken for dead
MOST_ATTEMPTS = 3
ENDED_STATES = ("done", "failed", "cancelled")


def add_job(db: Session, recordings: Sequence[str]) -> JobRow:
    """Queue a diagnosis of recordings.

    Raises:
        NotFoundError: one of the recordings does not exist.
    """
    for recording in recordings:
        if db.get(RecordingRow, recording) is None:
            raise NotFoundError("recording", recording)
    now = time.time()
    row = JobRow(
        id=secrets.token_hex(8),
        recordings=json.dumps(list(recordings)),
        state="queued",
        progress=0.0,
        doing="waiting",
        attempts=0,
        created=now,
        changed=now,
    )
    db.add(row)
    return row


def find_job(db: Session, job_id: str, *, for_change: bool = False) -> JobRow:
    """Return a job; `for_change` locks its row until the end of the transaction.

    Raises:
        NotFoundError: there is no job with this id.
    """
    row = db.get(JobRow, job_id, with_for_update=for_change)
    if row is None:
        raise NotFoundError("diagnosis", job_id)
    return row


def cancel_job(db: Session, job_id: str) -> JobRow:
    """Cancel a job that has not ended; its worker stops when it renews the lease.

    Raises:
        NotFoundError: there is no job with this id.
        StateError: the job has ended already.
    """
    row = find_job(db, job_id, for_change=True)
    if row.state in ENDED_STATES:
        raise StateError(f"diagnosis {job_id} is {row.state} already")
    row.state, row.doing, row.changed = "cancelled", "", time.time()
    return row


def job_view(row: JobRow) -> Job:
    """Return a job as clients see it."""
    return Job.model_validate(
        {
            "id": row.id, "recordings": json.loads(row.recordings), "state": row.state,
            "progress": row.progress, "doing": row.doing, "verdict": row.verdict, "says": row.says,
            "error": row.error, "attempts": row.attempts, "created": row.created, "changed": row.changed,
        }
    )  # fmt: skip


def has_queued(db: Session) -> bool:
    """Return whether a job waits to be claimed."""
    return db.scalar(select(JobRow.id).where(JobRow.state == "queued").limit(1)) is not None


def claim_job(db: Session, instance: str) -> str | None:
    """Claim the oldest queued job for a service; return its id, or None where another service was faster."""
    row = db.scalars(
        select(JobRow)
        .where(JobRow.state == "queued")
        .order_by(JobRow.created)
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


def finish_job(row: JobRow, outcome: dict[str, Any] | None) -> None:
    """Note how a diagnosis ended.

    Args:
        row: The job.
        outcome: What `DiagnosisProcess.outcome` returned.
    """
    if outcome is None:
        give_back(row, "the service was stopped")
    elif "died" in outcome:
        give_back(row, outcome["died"])
    elif "error" in outcome:
        row.state, row.error, row.doing = "failed", outcome["error"], ""
    else:
        row.state, row.progress, row.doing = "done", 1.0, ""
        row.verdict, row.says = outcome["verdict"], outcome["says"]
        row.result, row.report = outcome["result"], outcome["report"]
    row.changed = time.time()


def give_back(row: JobRow, reason: str) -> None:
    """Queue a job again, or let it fail after several attempts."""
    row.owner = row.lease = None
    row.changed = time.time()
    if row.attempts >= MOST_ATTEMPTS:
        row.state, row.error, row.doing = "failed", f"given up after {row.attempts} attempts: {reason}", ""
    else:
        row.state, row.doing = "queued", f"waiting again: {reason}"
