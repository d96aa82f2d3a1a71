"""From fixes to a return error, U (3.1): absolute minus calculated, in the frame of the start."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from service.errors import ValueProblem
from service.umbmark.models import ByWalls
from vcan_sim.sonar import Sonar
from vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from service.umbmark.models import Fix, Walls
    from vehicle.se2 import Array


def pose_of(fix: Fix, where: str) -> Array:
    """Return the pose `(3,)` of a fix; theta is nan where it was not measured.

    Raises:
        ValueProblem: no pose has such distances to the walls.
    """
    if isinstance(fix, ByWalls):
        return _of_walls(fix.walls, where)
    return np.array([fix.x, fix.y, math.nan if fix.theta is None else fix.theta], np.float64)


def _of_walls(walls: Walls, where: str) -> Array:
    own = walls.geometry
    sonar = Sonar(baseline=own.baseline, side=own.side, rear=own.rear, wall_x=own.wall_x, wall_y=own.wall_y)
    pose = sonar.solve(np.array([walls.right_front, walls.right_rear, walls.behind]))
    if not np.isfinite(pose).all():
        raise ValueProblem(
            f"{where}.walls",
            f"right_front and right_rear differ by more than their baseline of {own.baseline:g} m; "
            "measure them anew, perpendicular to the wall",
        )
    return pose


def return_error(before: Array, after: Array, calculated: Array) -> Array:
    """Return absolute minus calculated pose `(3,)` in the frame of `before`; theta is nan where unknown.

    Raises:
        ValueProblem: the heading of the start is not known.
    """
    if not math.isfinite(before[2]):
        raise ValueProblem("before.theta", "missing; expected the heading of the start (0 is usual)")
    absolute, odometry = between(before, after), between(before, calculated)
    error = absolute - odometry
    return np.array([error[0], error[1], float(wrap(error[2]))], np.float64)
