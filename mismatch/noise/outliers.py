"""Windows in which something happened to a truck: its noise is not to be taken for the floor's.

A dozen obstacles make a floor look ten times as rough as it is, and are then not seen on it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

HAPPENED = 16.27  # chi-square with three degrees of freedom that noise exceeds in one window of a thousand
SHOVE = np.array([3e-3, 3e-3, 1e-2])  # [m, m, rad] of a truck in one window, one standard deviation
_MOST = 0.2  # of all windows, and of what is measured: what happens more often is how the floor is


def freed(regression: Regression, rows: Array) -> tuple[list[Windows], int]:
    """Return the windows of each recording, where trucks may be pushed in some; and in how many of them.

    Args:
        regression: About the recordings.
        rows: What is left of them, whitened, `(V,)`.
    """
    loose, count = [], 0
    for windows, (scores, informations) in zip(regression.windows, regression.shocks(rows), strict=True):
        covariance = windows.rounding.copy()
        share = _MOST * min(1.0, np.isfinite(windows.measured).sum() / (3.0 * len(covariance)))
        for number in range(len(windows.signals.trucks)):
            own = slice(3 * number, 3 * number + 3)
            chi_square = power(scores[:, own], informations[:, own, own])
            least = max(HAPPENED, float(np.quantile(chi_square, 1.0 - share)))
            pushed = np.flatnonzero(chi_square > least)
            covariance[pushed, own, own] += np.diag(SHOVE**2)
            count += len(pushed)
        loose.append(replace(windows, rounding=covariance))
    return loose, count


def power(scores: Array, informations: Array) -> Array:
    """Return the chi-squares (M,) of pushes with scores (M, 3) and informations (M, 3, 3)."""
    size = np.einsum("mii->m", informations)[:, None, None] / 3.0
    solved = np.linalg.solve(informations + (1e-9 * size + 1e-300) * np.eye(3), scores[:, :, None])[:, :, 0]
    return np.asarray(np.einsum("mi,mi->m", scores, solved))
