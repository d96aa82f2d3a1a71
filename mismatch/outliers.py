"""Windows in which something happened to a truck: its own noise is not to be taken for the floor's.

A dozen obstacles make a floor look ten times as rough as it is, and are then not seen on it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.leftover import shocks
from omnimate.mismatch.surprise import SHOVE, power

if TYPE_CHECKING:
    from omnimate.mismatch.leftover import Leftover
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.windows import Windows

HAPPENED = 16.0  # chi-square of a free push, which noise reaches in one window of a thousand
_MOST = 0.1  # of all windows: what happens more often is how the floor is


def freed(regression: Regression, left: Leftover) -> tuple[list[Windows], int]:
    """Return the windows of each recording, where trucks may be pushed in some; and in how many of them.

    Args:
        regression: about the recordings.
        left: what is left of them.
    """
    loose, count = [], 0
    for windows, (scores, informations) in zip(regression.windows, shocks(regression, left), strict=True):
        covariance = windows.rounding.copy()
        for number in range(len(windows.signals.trucks)):
            own = slice(3 * number, 3 * number + 3)
            chi_square = power(scores[:, own], informations[:, own, own])
            least = max(HAPPENED, float(np.quantile(chi_square, 1.0 - _MOST)))
            pushed = np.flatnonzero(chi_square > least)
            covariance[pushed, own, own] += np.diag(SHOVE**2)
            count += len(pushed)
        loose.append(replace(windows, rounding=covariance))
    return loose, count
