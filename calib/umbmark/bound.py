"""The Cramer-Rao bound of a UMBmark: the smallest uncertainty of E_b and E_d of any unbiased method."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.umbmark.scatter import MIRROR
from omnimate.calib.umbmark.square import factor_scales, square_ends

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array


def factor_bound(
    truck: Truck, factors: tuple[float, float], side: float, runs: tuple[int, int], covariance: Array
) -> Array:
    """Return the smallest covariance `(2, 2)` of E_b and E_d that an unbiased estimate can have.

    Args:
        truck: The nominal truck.
        factors: The true E_b and E_d.
        side: Length of each side of the square [m].
        runs: Number of cw and of ccw runs.
        covariance: Covariance of the return error x, y [m], theta [rad] of one ccw run, shape `(3, 3)`; that
            of a cw run is its mirror image. An infinite variance means that the component is not measured.
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
