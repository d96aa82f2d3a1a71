"""Runs that do not fit the others of their set, by the median and its absolute deviation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.distributions import MAD_TO_SIGMA

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array

_LIMIT = 3.5  # [standard deviations] beyond it, a number is an outlier: Iglewicz & Hoaglin (1993)
_FEWEST = 3  # runs from which on one can differ from the others


def outlying_runs(values: Array, smallest: float) -> NDArray[np.bool_]:
    """Return which of N numbers `(N,)` lie above the median by 3.5 robust standard deviations and `smallest`.

    The standard deviation is that of the median absolute deviation, which fewer than half of the runs cannot
    change; of few runs it may be small by chance, so that a distance is required as well.
    """
    if len(values) < _FEWEST:
        return np.zeros(len(values), bool)
    away = values - np.median(values)
    sigma = MAD_TO_SIGMA * float(np.median(np.abs(away)))
    return np.asarray(away > max(_LIMIT * sigma, smallest), bool)
