"""The states of a session, and the calls that each of them allows."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.service.errors import ExpiredError, StateError

if TYPE_CHECKING:
    from omnimate.service.store.tables import SessionRow
    from omnimate.service.umbmark.fields import Call

OPEN_STATES = ("collecting", "driving", "measuring", "interrupted", "solved")

ALLOWED_CALLS: dict[str, tuple[Call, ...]] = {
    "collecting": ("sample", "remove", "solve", "abort"),
    "driving": ("abort",),
    "measuring": ("sample", "abort"),
    "interrupted": ("resume", "remove", "solve", "abort"),
    "solved": ("sample", "remove", "solve", "accept", "abort"),
}


def state_of(row: SessionRow, now: float) -> str:
    """Return the state of a session; an open session whose lifetime is over is expired."""
    may_expire = row.state in OPEN_STATES and row.state != "driving"
    return "expired" if may_expire and now > row.expires else row.state


def possible_calls(row: SessionRow, now: float) -> tuple[Call, ...]:
    """Return the calls that the session allows now.

    A session that the service drives takes its samples itself, except where a person has to measure.
    """
    calls = ALLOWED_CALLS.get(state_of(row, now), ())
    takes_samples_itself = row.how == "drive" and row.state != "measuring"
    return tuple(call for call in calls if not (call == "sample" and takes_samples_itself))


def require_call(row: SessionRow, call: Call, now: float) -> None:
    """Refuse a call that the session does not allow.

    Raises:
        ExpiredError: the session has expired.
        StateError: the state of the session does not allow the call.
    """
    state = state_of(row, now)
    if state == "expired":
        raise ExpiredError(f"session {row.id} has expired because it was not used in time; start a new one")
    allowed = possible_calls(row, now)
    if call not in allowed:
        raise StateError(f"session {row.id} is {state} and cannot take {call!r}", allowed)
