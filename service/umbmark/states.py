"""The states of a session and the calls that each allows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from service.errors import ExpiredError, StateError

if TYPE_CHECKING:
    from service.store.tables import SessionRow
    from service.umbmark.models import Call

OPEN = ("collecting", "driving", "measuring", "interrupted", "solved")
ENDED = ("accepted", "aborted", "failed", "expired")

_POSSIBLE: dict[str, tuple[Call, ...]] = {
    "collecting": ("sample", "remove", "solve", "abort"),
    "driving": ("abort",),
    "measuring": ("sample", "abort"),
    "interrupted": ("resume", "remove", "solve", "abort"),
    "solved": ("sample", "remove", "solve", "accept", "abort"),
}


def state_of(row: SessionRow, now: float) -> str:
    """Return the state; a session that nobody went on with is expired, whatever was written."""
    return "expired" if row.state in OPEN and row.state != "driving" and now > row.expires else row.state


def possible(row: SessionRow, now: float) -> tuple[Call, ...]:
    """Return the calls that the session allows now."""
    calls = _POSSIBLE.get(state_of(row, now), ())
    taken_by_itself = row.how == "drive" and row.state != "measuring"
    return tuple(call for call in calls if not (call == "sample" and taken_by_itself))


def demand(row: SessionRow, call: Call, now: float) -> None:
    """Refuse a call that the session does not allow.

    Raises:
        ExpiredError: nobody went on with the session in time.
        StateError: its state does not allow the call.
    """
    state = state_of(row, now)
    if state == "expired":
        raise ExpiredError(f"session {row.id} has expired: nobody went on with it in time; start a new one")
    allowed = possible(row, now)
    if call not in allowed:
        raise StateError(f"session {row.id} is {state} and cannot take {call!r}", allowed)
