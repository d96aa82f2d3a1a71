"""The Cramer-Rao bound of a UMBmark: how well any method at all could know E_b and E_d."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from calib.scatter import MIRROR
from calib.square import factor_scales, square_ends

if TYPE_CHECKING:
    from vehicle.parameters import Truck
    from vehicle.se2 import Array


def factor_bound(
    truck: Truck, factors: tuple[float, float], side: float, runs: tuple[int, int], covariance: Array
) -> Array:
    """Return the least covariance `(2, 2)` of E_b and E_d that an unbiased estimate can have.

    Args:
        truck: nominal.
        factors: the true E_b and E_d.
        side: of the square [m].
        runs: how many cw and ccw.
        covariance: (3, 3) of one ccw run's return error x, y [m], theta [rad]; that of a cw run is its
            mirror image. An infinite variance means: not measured.
    """
    logs = np.log(np.array(factors, np.float64))
    scales, by_logs = factor_scales(truck, logs)
    slopes = square_ends(truck, side, scales)[1] @ by_logs / np.exp(logs)
    used = np.isfinite(np.diag(covariance))
    information = np.zeros((2, 2))
    for slope, count, mirror in zip(slopes, runs, (MIRROR, np.ones(3)), strict=True):
        scatter = (np.outer(mirror, mirror) * covariance)[used][:, used]
        information += count * slope[used].T @ np.linalg.solve(scatter, slope[used])
    return np.asarray(np.linalg.inv(information), np.float64)
