"""Windows in which something happened to a truck: its noise is not to be taken for the floor's.

A dozen obstacles make a floor look ten times as rough as it is, and are then not seen on it. But levels that
were estimated without whatever exceeds them are too small, more exceeds these, and so on. So a window is left
out only if a push of the truck there is likelier than none, by Occam's factor and an event's odds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.evidence.density import log_evidence

if TYPE_CHECKING:
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

EVENT = math.log(1.0 / 50.0)  # log odds, in a window: once in a dozen seconds, as on a floor of slabs
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
            worth = EVENT + _likelier(scores[:, own], informations[:, own, own])
            pushed = np.flatnonzero(worth > max(0.0, float(np.quantile(worth, 1.0 - share))))
            covariance[pushed, own, own] += np.diag(SHOVE**2)
            count += len(pushed)
        loose.append(replace(windows, rounding=covariance))
    return loose, count


def _likelier(scores: Array, informations: Array) -> Array:
    """Return the log Bayes factors (M,) of pushes of usual size against none.

    Args:
        scores: Of a push in each window, `(M, 3)`.
        informations: Likewise, `(M, 3, 3)`.
    """
    return log_evidence(SHOVE[:, None] * informations * SHOVE, SHOVE * scores, 1.0)


def power(scores: Array, informations: Array) -> Array:
    """Return the chi-squares (M,) of pushes with scores (M, 3) and informations (M, 3, 3)."""
    size = np.einsum("mii->m", informations)[:, None, None] / 3.0
    solved = np.linalg.solve(informations + (1e-9 * size + 1e-300) * np.eye(3), scores[:, :, None])[:, :, 0]
    return np.asarray(np.einsum("mi,mi->m", scores, solved))
