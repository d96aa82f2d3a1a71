"""Disturbed windows, in which a truck was pushed: they must not raise the estimate of the floor's noise.

A dozen obstacles make a floor look ten times as rough as it is, and are then hidden in it. Yet noise levels
estimated without all that exceeds them shrink at every turn. So a window counts as disturbed only if a push
of the truck is likelier than none, by its Bayes factor and the odds of an event.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.pushes import PUSH_SIZE
from omnimate.mismatch.evidence.density import log_evidence

if TYPE_CHECKING:
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

EVENT = math.log(
    1.0 / 50.0
)  # log odds of a push in one window: once in a dozen seconds, as on a floor of slabs
MAX_DISTURBED_FRACTION = 0.2  # of windows, and of measurements: beyond it, the floor is rough


def inflate_disturbed_windows(regression: Regression, rows: Array) -> tuple[list[Windows], int]:
    """Return each recording's windows, with a push in the process noise of disturbed ones; count those.

    Args:
        regression: About the recordings.
        rows: Their whitened residual, `(V,)`.
    """
    inflated, count = [], 0
    for windows, (scores, informations) in zip(regression.windows, regression.push_scores(rows), strict=True):
        covariance = windows.rounding.copy()
        share = MAX_DISTURBED_FRACTION * min(
            1.0, np.isfinite(windows.measured).sum() / (3.0 * len(covariance))
        )
        for number in range(len(windows.signals.trucks)):
            own = slice(3 * number, 3 * number + 3)
            log_odds = EVENT + _push_evidence(scores[:, own], informations[:, own, own])
            pushed = np.flatnonzero(log_odds > max(0.0, float(np.quantile(log_odds, 1.0 - share))))
            covariance[pushed, own, own] += np.diag(PUSH_SIZE**2)
            count += len(pushed)
        inflated.append(replace(windows, rounding=covariance))
    return inflated, count


def _push_evidence(scores: Array, informations: Array) -> Array:
    """Return the log Bayes factors (M,) of pushes of a priori size against none.

    Args:
        scores: Of a push in each window, `(M, 3)`.
        informations: Likewise, `(M, 3, 3)`.
    """
    return log_evidence(PUSH_SIZE[:, None] * informations * PUSH_SIZE, PUSH_SIZE * scores, 1.0)


def power(scores: Array, informations: Array) -> Array:
    """Return the chi-squares (M,) of pushes with scores (M, 3) and informations (M, 3, 3)."""
    size = np.einsum("mii->m", informations)[:, None, None] / 3.0
    solved = np.linalg.solve(informations + (1e-9 * size + 1e-300) * np.eye(3), scores[:, :, None])[:, :, 0]
    return np.asarray(np.einsum("mi,mi->m", scores, solved))
