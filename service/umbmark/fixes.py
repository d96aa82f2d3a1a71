"""From fixes to a return error, U (3.1): absolute minus calculated pose, in the frame of the start."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.service.errors import InvalidValueError
from omnimate.service.umbmark.requests import ByWalls
from omnimate.vehicle.se2 import between, wrap
from omnimate.vehicle.sonar import Sonar

if TYPE_CHECKING:
    from omnimate.service.umbmark.requests import Fix, Walls
    from omnimate.vehicle.se2 import Array


def pose_of(fix: Fix, where: str) -> Array:
    """Return the pose `(3,)` of a fix; theta is nan where it was not measured.

    Args:
        fix: The fix, by coordinates or by distances to walls.
        where: The field of the request that holds the fix, for messages.

    Raises:
        InvalidValueError: no pose has such distances to the walls.
    """
    if isinstance(fix, ByWalls):
        return _pose_by_walls(fix.walls, where)
    return np.array([fix.x, fix.y, math.nan if fix.theta is None else fix.theta], np.float64)


def _pose_by_walls(walls: Walls, where: str) -> Array:
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
    """Return the return error `(3,)` of a run; theta is nan where it is not known.

    Args:
        before: The absolute pose `(3,)` before the run.
        after: The absolute pose `(3,)` after the run.
        calculated: The pose `(3,)` that odometry shows after the run.

    Raises:
        InvalidValueError: the heading before the run is not known.
    """
    if not math.isfinite(before[2]):
        raise InvalidValueError("before.theta", "missing; expected the heading at the start (usually 0)")
    absolute, odometry = between(before, after), between(before, calculated)
    error = absolute - odometry
    return np.array([error[0], error[1], float(wrap(error[2]))], np.float64)
