"""The roughness of the floor from the scatter of the return positions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.calib.distributions import chi2_quantile
from omnimate.calib.umbmark.uncertainty import CONFIDENCE, Interval
from omnimate.vehicle.floor import path_covariance

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.se2 import Array


def square_covariance(side: float, wheelbase: float, sign: float = 1.0) -> Array:
    """Return the covariance `(3, 3)` of a square's return error for a roughness of 1 m/sqrt(m).

    `side` and `wheelbase` are in metres; `sign` is +1 for ccw, -1 for cw.
    """
    corner = 0.25 * sign * math.pi * wheelbase
    return path_covariance([side, -corner] * 4, [side, corner] * 4, wheelbase)


def floor_roughness(errors: ReturnErrors, wheelbase: float) -> Interval:
    """Return the roughness k of the floor [m/sqrt(m)], taken the same under both wheels; nan for 1 + 1 runs.

    Its limits are those of a chi^2 distribution with as many degrees of freedom as the scatter has. The drift
    of the heading correlates x and y, so that the true number of degrees of freedom is a little smaller.
    """
    unit = square_covariance(errors.side, wheelbase)
    freedom, variance = errors.freedom, errors.scatter**2
    limits = (
        [freedom * variance / chi2_quantile(0.5 + half * CONFIDENCE, freedom) for half in (0.5, -0.5)]
        if freedom
        else [math.nan, math.nan]
    )
    k, low, high = (math.sqrt(each / unit[0, 0]) for each in (variance, *limits))
    return Interval(k, low, high)
