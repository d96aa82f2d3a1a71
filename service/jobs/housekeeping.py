"""What every service does regularly for all services on its database.

It takes back the work of services that have died, ends unused sessions, and forgets old answers.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from sqlalchemy import delete, select, update

from omnimate.service.jobs.queue import LEASE, give_back
from omnimate.service.store.tables import AnswerRow, JobRow, SessionRow, lease_ended
from omnimate.service.umbmark.sessions import OPEN_STATES, interrupt_orphans

if TYPE_CHECKING:
    from omnimate.service.store.database import Database

ANSWERS_KEPT = 86400.0  # [s] in which a request with an Idempotency-Key may be repeated


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
