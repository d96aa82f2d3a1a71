"""The runs of a session: added from fixes or with known return errors, removed, read."""

from __future__ import annotations

import json
import math
import time
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import func, select

from omnimate.calib.umbmark.return_errors import LONGEST
from omnimate.service.errors import InvalidValueError, NotFoundError, StateError
from omnimate.service.store.tables import SampleRow
from omnimate.service.umbmark.fixes import pose_of, return_error
from omnimate.service.umbmark.session_states import possible_calls
from omnimate.vehicle.se2 import compose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from sqlalchemy.orm import Session as Db

    from omnimate.service.store.tables import SessionRow
    from omnimate.service.umbmark.fields import Direction
    from omnimate.service.umbmark.requests import SampleOfFixes
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.se2 import Array

MOST_SAMPLES = 1000


def add_measured_sample(db: Db, row: SessionRow, request: SampleOfFixes) -> SampleRow:
    """Add the run that a client describes by fixes.

    Raises:
        InvalidValueError: the poses do not give a possible return error.
        StateError: the session takes its runs from recordings, or a value is missing.
    """
    if row.how == "recordings":
        raise StateError("this session takes its runs from uploaded recordings; send the id of a recording")
    direction, calculated = _direction(row, request), _calculated(row, request)
    error = return_error(_start(request), pose_of(request.after, "after"), calculated)
    sample = add_sample(db, row, direction, {request.truck: error}, "fixes")
    row.pending = None
    return sample


def _start(request: SampleOfFixes) -> Array:
    return np.zeros(3) if request.before is None else pose_of(request.before, "before")


def _direction(row: SessionRow, request: SampleOfFixes) -> Direction:
    driven: Direction | None = json.loads(row.pending)["direction"] if row.pending else None
    if driven is not None and request.direction not in {None, driven}:
        raise StateError(f"the driven lap that has to be measured is {driven}, not {request.direction}")
    direction = request.direction or driven
    if direction is None:
        raise StateError("direction is missing, and there is no driven lap that gives it; send cw or ccw")
    return direction


def _calculated(row: SessionRow, request: SampleOfFixes) -> Array:
    """Return the pose of odometry at the end: as sent, or as the driven lap gives it from its start."""
    if request.calculated is not None:
        return pose_of(request.calculated, "calculated")
    if row.pending is None:
        raise StateError(
            "`calculated` is missing, and there is no driven lap that gives it; send the pose of odometry at "
            "the end of the run"
        )
    driven = json.loads(row.pending)["calculated"].get(request.truck)
    if driven is None:
        raise InvalidValueError("truck", f"the robot has no truck {request.truck!r}")
    return np.asarray(compose(_start(request), driven), np.float64)


def add_sample(
    db: Db,
    row: SessionRow,
    direction: Direction,
    errors: Mapping[TruckName, Array],
    source: str,
    recording: str | None = None,
) -> SampleRow:
    """Add a run by the return error `(3,)` of each truck; a former result of the session is discarded.

    Raises:
        InvalidValueError: a return error is too large to be one of odometry.
        StateError: the session has the largest number of runs already.
    """
    for truck, error in errors.items():
        _check_size(row, truck, error)
    last = db.scalar(select(func.max(SampleRow.number)).where(SampleRow.session == row.id)) or 0
    if last >= MOST_SAMPLES:
        raise StateError(
            f"a session takes {MOST_SAMPLES} runs at most; solve it", possible_calls(row, time.time())
        )
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
    _discard_result(row)
    return sample


def _check_size(row: SessionRow, truck: TruckName, error: Array) -> None:
    size = math.hypot(error[0], error[1])
    if not size <= LONGEST * row.side:
        raise InvalidValueError(
            "after",
            f"the return error of truck {truck} would be {size:.3g} m, which is no error of odometry in a "
            f"square of {row.side:g} m; check that all lengths are metres and both poses are in one frame",
        )


def _as_json(error: Array) -> dict[str, float | None]:
    theta = float(error[2])
    return {"x": float(error[0]), "y": float(error[1]), "theta": theta if math.isfinite(theta) else None}


def remove_sample(db: Db, row: SessionRow, number: int) -> None:
    """Remove a run; a former result of the session is discarded.

    Raises:
        NotFoundError: the session has no run with this number.
    """
    sample = db.get(SampleRow, (row.id, number))
    if sample is None:
        raise NotFoundError(f"run of session {row.id}:", str(number))
    db.delete(sample)
    _discard_result(row)


def _discard_result(row: SessionRow) -> None:
    row.result = None
    if row.state == "solved":
        row.state = "collecting"
