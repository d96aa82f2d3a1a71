"""UMBmark sessions in the database: their states and results, driven by one service at a time."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from sqlalchemy import func, select

from omnimate.calib.apply import corrected_vehicle
from omnimate.service.errors import ExpiredError, ModifiedError, StateError
from omnimate.service.store import vehicles
from omnimate.service.store.tables import SampleRow, SessionRow, find_row, lease_ended
from omnimate.service.umbmark.models import Counts, Result, Session
from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy.orm import Session as Db

    from omnimate.service.store.tables import VehicleRow
    from omnimate.service.umbmark.models import Call, Direction, SessionStart
    from omnimate.vehicle.parameters import VehicleParameters

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


def refusal(row: SessionRow, problem: str) -> StateError:
    """Return the error of a call that the session does not allow as it was made."""
    return StateError(problem, possible_calls(row, time.time()))


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


def start_session(db: Db, request: SessionStart, vehicle: str, lifetime: float) -> SessionRow:
    """Start a session with the newest version of a vehicle; unused for its lifetime [s], it expires."""
    now = time.time()
    row = SessionRow(
        vehicle=vehicle,
        vehicle_version=vehicles.newest(db, vehicle).version,
        created=now,
        changed=now,
        expires=now + lifetime,
        **request.model_dump(exclude={"vehicle"}),
    )
    db.add(row)
    db.flush()
    return row


def session_for(db: Db, session_id: str, call: Call, lifetime: float) -> SessionRow:
    """Return a session, locked, for a call that it allows; unused for its lifetime [s], it expires."""
    row = find_row(db, SessionRow, session_id, for_change=True)
    now = time.time()
    require_call(row, call, now)
    row.changed, row.expires = now, now + lifetime
    return row


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


def interrupt_orphans(db: Db) -> list[str]:
    """Interrupt the sessions whose service has died; return their ids."""
    orphaned = (SessionRow.state == "driving") & lease_ended(SessionRow.lease, time.time(), LEASE)
    rows = db.scalars(select(SessionRow).where(orphaned).with_for_update()).all()
    for row in rows:
        reason = "the service that drove it has ended, or could not write to the database"
        end_lease(row, "interrupted", f"interrupted: {reason}")
    return [row.id for row in rows]


def session_view(row: SessionRow, counts: Counts, samples: list[SampleRow] | None = None) -> Session:
    """Return a session as clients see it."""
    now = time.time()
    progress = f"cw {counts.cw} of {row.runs}, ccw {counts.ccw} of {row.runs}"
    return Session.of(
        row,
        state=state_of(row, now),
        detail=row.detail or progress,
        possible=possible_calls(row, now),
        counts=counts,
        samples=samples,
    )


def session_with_samples(db: Db, row: SessionRow) -> Session:
    """Return a session with its runs."""
    db.flush()
    return session_view(row, count_samples(db, [row.id])[row.id], samples_of(db, row))


def count_samples(db: Db, session_ids: Iterable[str]) -> dict[str, Counts]:
    """Return the number of runs in each direction, by the id of the session."""
    counts = {session_id: Counts(cw=0, ccw=0) for session_id in session_ids}
    query = (
        select(SampleRow.session, SampleRow.direction, func.count())
        .where(SampleRow.session.in_(counts))
        .group_by(SampleRow.session, SampleRow.direction)
    )
    for session_id, direction, number in db.execute(query):
        setattr(counts[session_id], direction, number)
    return counts


def samples_of(db: Db, row: SessionRow) -> list[SampleRow]:
    """Return the runs of a session in the order of their numbers."""
    rows = db.scalars(select(SampleRow).where(SampleRow.session == row.id).order_by(SampleRow.number))
    return list(rows)


def next_direction(db: Db, row: SessionRow) -> Direction | None:
    """Return the direction that has fewer runs, cw first; None when all runs are driven."""
    counts = count_samples(db, [row.id])[row.id]
    if min(counts.cw, counts.ccw) >= row.runs:
        return None
    return "cw" if counts.cw <= counts.ccw else "ccw"


def store_result(db: Db, row: SessionRow, samples: Iterable[SampleRow], result: Result) -> None:
    """Make a result that of its session; StateError where that has other runs than it was calculated from."""
    if _identities(samples_of(db, row)) != _identities(samples):
        raise refusal(row, f"the runs of session {row.id} changed while it was solved; solve it again")
    row.state, row.result, row.detail = "solved", result.model_dump_json(), ""


def _identities(samples: Iterable[SampleRow]) -> list[tuple[int, float]]:
    """Return what distinguishes runs: a number may be used again after its run was removed."""
    return [(sample.number, sample.created) for sample in samples]


def last_result(row: SessionRow) -> Result:
    """Return the result of the last solve; StateError where the session has no result."""
    if row.result is None:
        raise refusal(row, f"session {row.id} has no result")
    return Result.model_validate_json(row.result)


def accept_result(
    db: Db, row: SessionRow, revision: str | None, made_by: str | None, *, force: bool
) -> VehicleRow:
    """Make a session's result, of the revision that the caller has seen, the newest version of its vehicle.

    Raises:
        ModifiedError: the result has another revision, or the vehicle has a newer version.
        StateError: a check of the result reports an error, and `force` is not set.
    """
    result = last_result(row)
    if revision is not None and revision != result.revision:
        raise ModifiedError(
            f"the result has the revision {result.revision}, not {revision}; get the result again"
        )
    if not result.usable and not force:
        raise refusal(
            row, "a check of this result reports an error (see advice); send force to use it anyway"
        )
    trucks = {name: Truck(**truck.calibrated.model_dump()) for name, truck in result.trucks.items()}
    vehicle = corrected_vehicle(vehicle_of(db, row), trucks)
    origin = vehicles.Origin(f"session {row.id}", made_by, row.id)
    version = vehicles.add_version(db, vehicle, origin, row.vehicle_version)
    row.state, row.detail = "accepted", f"vehicle {row.vehicle} is now at version {version.version}"
    return version


def vehicle_of(db: Db, row: SessionRow) -> VehicleParameters:
    """Return the parameters of the vehicle that the session calibrates."""
    return vehicles.parameters_of(vehicles.version(db, row.vehicle, row.vehicle_version))
