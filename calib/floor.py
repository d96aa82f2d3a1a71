"""How rough the floor was, from the scatter of the return positions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scipy.stats import chi2

from calib.roughness import Roughness, square_covariance
from calib.uncertainty import Interval

if TYPE_CHECKING:
    from calib.return_errors import ReturnErrors


def floor_roughness(
    errors: ReturnErrors, wheelbase: float, fix_sigma: float = 0.0, confidence: float = 0.95
) -> Interval:
    """Return the roughness k of the floor [m/sqrt(m)], taken the same under both wheels; nan for 1 + 1 runs.

    Its limits are those of a chi^2 with as many degrees of freedom as the scatter of x and y has, which x
    and y correlated by the same drift have a little less of.

    Args:
        errors: of the runs.
        wheelbase: [m].
        fix_sigma: of x and y of one absolute fix [m]; each run has two.
        confidence: of the interval.
    """
    unit = square_covariance(errors.side, wheelbase, Roughness(1.0, 1.0))
    freedom = len(errors.cw) + len(errors.ccw) - 2
    variance = errors.scatter**2
    limits = (
        [freedom * variance / chi2.ppf(0.5 + half * confidence, freedom) for half in (0.5, -0.5)]
        if freedom
        else [math.nan, math.nan]
    )
    k, low, high = (math.sqrt(max(0.0, one - 2.0 * fix_sigma**2) / unit[0, 0]) for one in (variance, *limits))
    return Interval(k, low, high)
