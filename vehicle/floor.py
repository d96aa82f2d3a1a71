"""Covariance of odometry from the roughness of a floor.

The travel of each wheel scatters independently with the square root of the distance; the
roughness is its standard deviation after one metre [m/sqrt(m)]. Source of the law: Chong & Kleeman, Accurate
odometry and error modelling for a mobile robot, ICRA 1997.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import arc, integrate, wheel_levers
from omnimate.vehicle.se2 import compose

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.se2 import Array

# [m/sqrt(m)] With a wheelbase of 340 mm it makes the return position of a 4 x 4 m square scatter by 25 mm in
# x and in y, as U V reports: shown by `pytest tests/vcan_sim/test_floor.py`. The heading then scatters by
# 0.54 degrees.
CONCRETE_ROUGHNESS = 5.6e-4
QUADRATURE_NODES = 24  # of the Gauss-Legendre rule along an arc: exact to rounding up to two revolutions


def floor_covariance(levers: Array, travel: Array) -> Array:
    """Return the covariances `(..., 3, 3)` of poses for a roughness of 1 m/sqrt(m).

    `levers` `(..., 3, 2)` are their derivatives by the `travel` `(..., 2)` of both wheels [m].
    """
    scattered = levers * np.sqrt(np.abs(travel))[..., np.newaxis, :]
    return np.asarray(scattered @ np.swapaxes(scattered, -1, -2), np.float64)


def path_covariance(left: ArrayLike, right: ArrayLike, wheelbase: float) -> Array:
    """Return the covariance `(3, 3)` after a path of long arcs for a roughness of 1 m/sqrt(m).

    It is that of x, y [m] and theta [rad] in the frame of the path's start. `left` and `right` `(N,)` are the
    travel of the wheels in each arc [m]; a straight line (left = right) and a turn on the spot (left =
    -right) are arcs too.
    """
    travel = np.stack([np.asarray(left, np.float64), np.asarray(right, np.float64)], axis=-1)
    node, weight = np.polynomial.legendre.leggauss(QUADRATURE_NODES)
    share = 0.5 + 0.5 * node
    corners = integrate(arc(travel[:, 0], travel[:, 1], wheelbase))
    along = arc(np.outer(travel[:, 0], share), np.outer(travel[:, 1], share), wheelbase)
    poses = compose(corners[:-1, np.newaxis], along)
    levers = wheel_levers(poses[..., 2], corners[-1, :2] - poses[..., :2], wheelbase)
    parts = travel[:, np.newaxis] * (0.5 * weight)[:, np.newaxis]
    return np.asarray(floor_covariance(levers, parts).sum(axis=(0, 1)), np.float64)
