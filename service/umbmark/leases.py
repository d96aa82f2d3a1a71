"""Leases of sessions that a service drives: a service that does not renew its lease is taken for dead."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from sqlalchemy import select

from omnimate.service.store.tables import SessionRow

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

LEASE = 10.0  # [s]


def take_lease(row: SessionRow, instance: str) -> None:
    """Note that a service drives for the session from now on."""
    row.state, row.detail, row.owner = "driving", "", instance
    renew_lease(row)


def renew_lease(row: SessionRow) -> None:
    """Note that the service that drives for the session is alive."""
    row.lease = time.time() + LEASE


def end_lease(row: SessionRow, state: str, detail: str) -> None:
    """Note that no service drives for the session any more, and the state in which that leaves it."""
    row.state, row.detail, row.owner, row.lease = state, detail, None, None
    row.changed = time.time()


def drives_for(row: SessionRow, instance: str) -> bool:
    """Return whether a service drives for the session."""
    return row.state == "driving" and row.owner == instance


def interrupt_orphans(db: Session) -> list[str]:
    """Interrupt the sessions whose service has died; return their ids."""
    orphaned = (SessionRow.state == "driving") & (SessionRow.lease < time.time())
    rows = db.scalars(select(SessionRow).where(orphaned).with_for_update()).all()
    for row in rows:
        end_lease(row, "interrupted", "interrupted: the service that drove it has ended")
    return [row.id for row in rows]
