"""The runs of a session: added from fixes or with known return errors, removed, read."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import func, select

from omnimate.calib.umbmark.return_errors import MAX_RETURN_SIDES
from omnimate.service.errors import InvalidValueError, NotFoundError
from omnimate.service.store.tables import SampleRow
from omnimate.service.umbmark.models import ByWalls, ReturnError
from omnimate.service.umbmark.sessions import next_direction, refusal
from omnimate.vehicle.se2 import between, compose, wrap
from omnimate.vehicle.sonar import Sonar

if TYPE_CHECKING:
    from sqlalchemy.orm import Session as Db

    from omnimate.service.store.tables import SessionRow
    from omnimate.service.umbmark.models import Direction, Fix, SampleOfFixes
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

MAX_SAMPLES = 1000


def add_measured_sample(db: Db, row: SessionRow, request: SampleOfFixes) -> SampleRow:
    """Add the run that a client describes by fixes.

    Raises:
        InvalidValueError: the poses do not give a possible return error.
        StateError: the session takes its runs from recordings, or a value is missing.
    """
    if row.how == "recordings":
        raise refusal(row, "this session takes its runs from uploaded recordings; send the id of a recording")
    direction = _direction(row, request)
    before = np.zeros(3) if request.before is None else pose_of(request.before, "before")
    error = return_error(before, pose_of(request.after, "after"), _calculated(row, request, before))
    sample = SampleRow(direction=direction, errors={request.truck: ReturnError.model_validate(error)})
    row.pending = None
    return add_sample(db, row, sample, "fixes")


def _direction(row: SessionRow, request: SampleOfFixes) -> Direction:
    driven: Direction | None = row.pending["direction"] if row.pending else None
    if driven is not None and request.direction not in {None, driven}:
        raise refusal(row, f"the driven lap that has to be measured is {driven}, not {request.direction}")
    direction = request.direction or driven
    if direction is None:
        raise refusal(row, "direction is missing, and there is no driven lap that gives it; send cw or ccw")
    return direction


def _calculated(row: SessionRow, request: SampleOfFixes, before: Array) -> Array:
    """Return the pose of odometry at the end: as sent, or as the driven lap gives it from `before`."""
    if request.calculated is not None:
        return pose_of(request.calculated, "calculated")
    if row.pending is None:
        raise refusal(
            row,
            "`calculated` is missing, and there is no driven lap that gives it; send the pose of odometry at "
            "the end of the run",
        )
    driven = row.pending["calculated"].get(request.truck)
    if driven is None:
        raise InvalidValueError("truck", f"the robot has no truck {request.truck!r}")
    return np.asarray(compose(before, driven), np.float64)


def add_sample(
    db: Db, row: SessionRow, sample: SampleRow, source: str, recording: str | None = None
) -> SampleRow:
    """Add a run to a session; a former result of the session is discarded.

    The run has its direction and the return error of each truck; `source` says in words where it comes from.

    Raises:
        InvalidValueError: a return error is too large to be one of odometry.
        StateError: the session has the largest number of runs already.
    """
    for truck, error in sample.errors.items():
        size = math.hypot(error.x, error.y)
        if not size <= MAX_RETURN_SIDES * row.side:
            raise InvalidValueError(
                "after",
                f"the return error of truck {truck} would be {size:.3g} m, which is no error of odometry in "
                f"a square of {row.side:g} m; check that all lengths are metres and both poses are in one "
                "frame",
            )
    last = db.scalar(select(func.max(SampleRow.number)).where(SampleRow.session == row.id)) or 0
    if last >= MAX_SAMPLES:
        raise refusal(row, f"a session takes {MAX_SAMPLES} runs at most; solve it")
    sample.session, sample.number, sample.created = row.id, last + 1, time.time()
    sample.source, sample.recording = source, recording
    db.add(sample)
    _discard_result(row)
    return sample


def require_new(db: Db, row: SessionRow, recording: str) -> None:
    """Refuse, by StateError, a recording whose runs the session has: twice, they would look more certain."""
    of_recording = (SampleRow.session == row.id) & (SampleRow.recording == recording)
    number = db.scalar(select(func.min(SampleRow.number)).where(of_recording))
    if number is not None:
        raise refusal(
            row, f"recording {recording} is in session {row.id} already, from run {number} on; add another"
        )


def squares_of(recording: Recording, vehicle: VehicleParameters, side: float) -> list[SampleRow]:
    """Return the squares of a recording in order, as runs of no session yet; none where it has no fixes.

    CalibrationError where a lap is no square of this side [m], or has no fix before or after it.
    """
    from omnimate.calib.recordings import has_fixes
    from omnimate.calib.umbmark.runs import square_runs

    squares: list[SampleRow] = []
    for name, truck in vehicle.trucks.items():
        for number, run in enumerate(square_runs(recording, name) if has_fixes(recording, name) else ()):
            run.check(truck, side)
            if number == len(squares):
                squares.append(SampleRow(direction=run.direction, errors={}))
            squares[number].errors[name] = ReturnError.model_validate(run.return_error(truck))
    return squares


def remove_sample(db: Db, row: SessionRow, number: int) -> None:
    """Remove a run, or raise NotFoundError; a former result of the session is discarded.

    A session that the robot drives is interrupted where a run is missing now: `resume` drives another one.
    """
    sample = db.get(SampleRow, (row.id, number))
    if sample is None:
        raise NotFoundError(f"run of session {row.id}:", str(number))
    db.delete(sample)
    _discard_result(row)
    if row.how == "drive" and next_direction(db, row) is not None:
        row.state, row.detail = "interrupted", f"interrupted: run {number} was removed"


def _discard_result(row: SessionRow) -> None:
    row.result = None
    if row.state == "solved":
        row.state = "collecting"


def pose_of(fix: Fix, where: str) -> Array:
    """Return the pose `(3,)` of a fix in the field `where`; theta is nan where it was not measured.

    InvalidValueError where no pose has such distances to the walls.
    """
    if not isinstance(fix, ByWalls):
        return np.array([fix.x, fix.y, math.nan if fix.theta is None else fix.theta], np.float64)
    walls = fix.walls
    sonar = Sonar(**walls.geometry.model_dump())
    pose = sonar.solve(np.array([walls.right_front, walls.right_rear, walls.behind]))
    if not np.isfinite(pose).all():
        raise InvalidValueError(
            f"{where}.walls",
            f"right_front and right_rear differ by more than their baseline of "
            f"{walls.geometry.baseline:g} m; measure them again, perpendicular to the wall",
        )
    return pose


def return_error(before: Array, after: Array, calculated: Array) -> Array:
    """Return the return error `(3,)` of a run, of which theta is nan where it is not known.

    It is that of the absolute poses `(3,)` before and after it, and of odometry `(3,)` after it;
    InvalidValueError where the heading before it is not known.
    """
    if not math.isfinite(before[2]):
        raise InvalidValueError("before.theta", "missing; expected the heading at the start (usually 0)")
    error = between(before, after) - between(before, calculated)
    return np.array([error[0], error[1], float(wrap(error[2]))], np.float64)
