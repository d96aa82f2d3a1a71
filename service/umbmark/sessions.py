"""UMBmark sessions in the database: started, found, and prepared for a change."""

from __future__ import annotations

import secrets
import time
from typing import TYPE_CHECKING

from omnimate.service.store import vehicles
from omnimate.service.store.rows import find_row
from omnimate.service.store.tables import SessionRow
from omnimate.service.umbmark.session_states import require_call

if TYPE_CHECKING:
    from sqlalchemy.orm import Session as Db

    from omnimate.service.umbmark.fields import Call
    from omnimate.service.umbmark.requests import SessionStart


def start_session(db: Db, request: SessionStart, vehicle: str, lifetime: float) -> SessionRow:
    """Start a session with the newest version of a vehicle.

    Args:
        db: The open transaction.
        request: The square that is going to be driven.
        vehicle: The name of the vehicle.
        lifetime: The time after which an unused session expires [s].

    Raises:
        NotFoundError: there is no such vehicle.
    """
    now = time.time()
    row = SessionRow(
        id=secrets.token_hex(8),
        vehicle=vehicle,
        vehicle_version=vehicles.newest(db, vehicle).version,
        side=request.side,
        runs=request.runs,
        how=request.how,
        speed=request.speed,
        lifeline=request.lifeline,
        state="collecting",
        created=now,
        changed=now,
        expires=now + lifetime,
        detail="",
    )
    db.add(row)
    db.flush()
    return row


def session_for(db: Db, session_id: str, call: Call) -> SessionRow:
    """Return a session, locked, on which a call may be carried out.

    Raises:
        NotFoundError: there is no session with this id.
        ExpiredError: the session has expired.
        StateError: the state of the session does not allow the call.
    """
    row = find_row(db, SessionRow, session_id, for_change=True)
    require_call(row, call, time.time())
    return row


def extend_lifetime(row: SessionRow, lifetime: float) -> None:
    """Note that a session was used now, so that it expires `lifetime` [s] later."""
    row.changed = time.time()
    row.expires = row.changed + lifetime
