"""What happens to a session: started, sampled, solved, accepted, aborted; each in one transaction."""

from __future__ import annotations

import json
import math
import secrets
import time
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import func, select

from service.errors import ChangedError, NotThereError, StateError, ValueProblem
from service.store import vehicles
from service.store.tables import SampleRow, SessionRow
from service.umbmark.fixes import pose_of, return_error
from service.umbmark.models import Counts, Result, ReturnError, Sample, Session
from service.umbmark.states import demand, possible, state_of
from vehicle.se2 import compose

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from sqlalchemy.orm import Session as Db

    from service.store.tables import VehicleRow
    from service.umbmark.models import Call, Method, SampleOfFixes, SessionStart, Turn
    from vehicle.parameters import TruckName
    from vehicle.se2 import Array

_FAR = 0.5  # of the side: a return error beyond it is no error of odometry


def start(db: Db, given: SessionStart, vehicle: str, lifetime: float) -> SessionRow:
    """Begin a session with a vehicle; `lifetime` [s] is how long nobody may go on with it.

    Raises:
        NotThereError: there is no such vehicle.
    """
    now = time.time()
    row = SessionRow(
        id=secrets.token_hex(8),
        vehicle=vehicle,
        vehicle_version=vehicles.newest(db, vehicle).version,
        side=given.side,
        runs=given.runs,
        how=given.how,
        speed=given.speed,
        lifeline=given.lifeline,
        state="collecting",
        created=now,
        changed=now,
        expires=now + lifetime,
        detail="",
    )
    db.add(row)
    db.flush()
    return row


def session(db: Db, name: str, *, change: bool = False) -> SessionRow:
    """Return a session; `change` keeps others from changing it meanwhile.

    Raises:
        NotThereError: there is none of this id.
    """
    row = db.get(SessionRow, name, with_for_update=change)
    if row is None:
        raise NotThereError("session", name)
    return row


def opened(db: Db, name: str, call: Call) -> SessionRow:
    """Return a session that is going to be changed by a call.

    Raises:
        NotThereError, ExpiredError, StateError: it is not there, or does not allow the call.
    """
    row = session(db, name, change=True)
    demand(row, call, time.time())
    return row


def touched(row: SessionRow, lifetime: float) -> None:
    """Note that somebody goes on with a session."""
    row.changed = time.time()
    row.expires = row.changed + lifetime


def add_given(db: Db, row: SessionRow, given: SampleOfFixes) -> list[SampleRow]:
    """Add the run that a client describes by fixes.

    Raises:
        ValueProblem: what was measured is no return error.
        StateError: the session takes recordings, or something is missing that no driven lap tells.
    """
    if row.how == "recordings":
        raise StateError("this session takes its runs from uploaded recordings; send the id of one")
    direction, calculated = _direction(row, given), _calculated(row, given)
    error = return_error(_start(given), pose_of(given.after, "after"), calculated)
    added = add(db, row, direction, {given.truck: error}, "fixes")
    row.pending = None
    return [added]


def _start(given: SampleOfFixes) -> Array:
    return np.zeros(3) if given.before is None else pose_of(given.before, "before")


def _direction(row: SessionRow, given: SampleOfFixes) -> Turn:
    waiting = json.loads(row.pending)["direction"] if row.pending else None
    if waiting is not None and given.direction not in {None, waiting}:
        raise StateError(f"the lap that waits to be measured was driven {waiting}, not {given.direction}")
    direction: Turn | None = given.direction or waiting
    if direction is None:
        raise StateError("no lap was driven that would tell the direction; send it: cw or ccw")
    return direction


def _calculated(row: SessionRow, given: SampleOfFixes) -> Array:
    """Return where odometry ends: as given, or as the driven lap tells it from its start."""
    if given.calculated is not None:
        return pose_of(given.calculated, "calculated")
    if row.pending is None:
        raise StateError("no lap was driven that would tell where odometry ends; send it as `calculated`")
    driven = json.loads(row.pending)["calculated"].get(given.truck)
    if driven is None:
        raise ValueProblem("truck", f"the robot has no truck {given.truck!r}")
    return np.asarray(compose(_start(given), driven), np.float64)


def add(
    db: Db,
    row: SessionRow,
    direction: Turn,
    errors: Mapping[TruckName, Array],
    source: str,
    recording: str | None = None,
) -> SampleRow:
    """Add one run; a result that was there is no longer up to date.

    Raises:
        ValueProblem: the errors are too large to be a robot's.
        StateError: there are more runs than anybody drives.
    """
    for truck, error in errors.items():
        _check(row, truck, error)
    last = db.scalar(select(func.max(SampleRow.number)).where(SampleRow.session == row.id)) or 0
    if last >= 1000:
        raise StateError("a session takes 1000 runs at most; solve it", possible(row, time.time()))
    sample = SampleRow(
        session=row.id,
        number=last + 1,
        direction=direction,
        errors=json.dumps({truck: _as_json(error) for truck, error in errors.items()}),
        source=source,
        recording=recording,
        created=time.time(),
    )
    db.add(sample)
    _stale(row)
    return sample


def _check(row: SessionRow, truck: TruckName, error: Array) -> None:
    size = math.hypot(error[0], error[1])
    if not size <= _FAR * row.side:
        raise ValueProblem(
            "after",
            f"the return error of truck {truck} would be {size:.3g} m, which is no error of odometry in a "
            f"square of {row.side:g} m; check that all lengths are metres and both poses are in one frame",
        )


def _as_json(error: Array) -> dict[str, float | None]:
    theta = float(error[2])
    return {"x": float(error[0]), "y": float(error[1]), "theta": theta if math.isfinite(theta) else None}


def remove(db: Db, row: SessionRow, number: int) -> None:
    """Leave a run out.

    Raises:
        NotThereError: there is no such run.
    """
    sample = db.get(SampleRow, (row.id, number))
    if sample is None:
        raise NotThereError(f"run of session {row.id}:", str(number))
    db.delete(sample)
    _stale(row)


def _stale(row: SessionRow) -> None:
    row.result = None
    if row.state == "solved":
        row.state = "collecting"


def samples(db: Db, row: SessionRow) -> list[Sample]:
    """Return the runs of a session in order."""
    rows = db.scalars(select(SampleRow).where(SampleRow.session == row.id).order_by(SampleRow.number))
    return [sample_view(one) for one in rows]


def sample_view(row: SampleRow) -> Sample:
    """Return a run as clients see it."""
    errors = {truck: ReturnError(**error) for truck, error in json.loads(row.errors).items()}
    return Sample(
        number=row.number,
        direction="cw" if row.direction == "cw" else "ccw",
        created=row.created,
        errors=errors,
        source=row.source,
        recording=row.recording,
    )


def solve(db: Db, row: SessionRow, method: Method) -> Result:
    """Solve a session from the runs that it has.

    Raises:
        ValueProblem: a direction is missing, or the data do not allow the method.
    """
    from service.umbmark.result import result_of  # with scipy's statistics, which take a second to load

    vehicle = vehicles.parameters(vehicles.version(db, row.vehicle, row.vehicle_version))
    found = result_of(row, samples(db, row), vehicle, method)
    row.state, row.result, row.detail = "solved", found.model_dump_json(), ""
    return found


def result(row: SessionRow) -> Result:
    """Return the result of the last solve.

    Raises:
        StateError: there is none.
    """
    if row.result is None:
        raise StateError(f"session {row.id} has no result", possible(row, time.time()))
    return Result.model_validate_json(row.result)


def accept(db: Db, row: SessionRow, revision: str | None, *, force: bool) -> VehicleRow:
    """Make a session's result the newest version of its vehicle.

    Raises:
        ChangedError: the result is another one than the caller saw, or the vehicle has a newer version.
        StateError: a guard calls the result an error, and nobody insists.
    """
    from service.umbmark.result import calibrated_vehicle

    found = result(row)
    if revision is not None and revision != found.revision:
        raise ChangedError(f"the result is of revision {found.revision}, not {revision}; look at it again")
    if not found.usable and not force:
        raise StateError(
            "a guard says that this result is not to be used (see advice); send force to use it nevertheless"
        )
    vehicle = vehicles.parameters(vehicles.version(db, row.vehicle, row.vehicle_version))
    version = vehicles.replace(
        db, calibrated_vehicle(vehicle, found), f"session {row.id}", row.vehicle_version
    )
    row.state, row.detail = "accepted", f"vehicle {row.vehicle} is now at version {version.version}"
    return version


def view(row: SessionRow, counts: Counts, runs: list[Sample] | None = None) -> Session:
    """Return a session as clients see it."""
    now = time.time()
    state = state_of(row, now)
    wanted = f"cw {counts.cw} of {row.runs}, ccw {counts.ccw} of {row.runs}"
    return Session.model_validate(
        {
            "id": row.id, "vehicle": row.vehicle, "vehicle_version": row.vehicle_version, "side": row.side,
            "runs": row.runs, "how": row.how, "state": state, "detail": row.detail or wanted,
            "possible": list(possible(row, now)), "created": row.created, "changed": row.changed,
            "expires": row.expires, "counts": counts, "samples": runs,
        }
    )  # fmt: skip


def counts(db: Db, ids: Iterable[str]) -> dict[str, Counts]:
    """Return how many runs of each direction sessions have, by id."""
    found = {one: Counts(cw=0, ccw=0) for one in ids}
    query = (
        select(SampleRow.session, SampleRow.direction, func.count())
        .where(SampleRow.session.in_(found))
        .group_by(SampleRow.session, SampleRow.direction)
    )
    for name, direction, number in db.execute(query):
        setattr(found[name], direction, number)
    return found


def full_view(db: Db, row: SessionRow) -> Session:
    """Return a session with its runs."""
    db.flush()
    return view(row, counts(db, [row.id])[row.id], samples(db, row))
