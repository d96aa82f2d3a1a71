"""Disturbed windows, in which a truck was pushed: they must not raise the estimate of the floor's noise.

A dozen obstacles raise the estimated roughness tenfold, and are then hidden in it. Yet noise levels that are
estimated without everything that exceeds them shrink in every iteration. So a window counts as disturbed only
if a push of the truck is more probable than none, by its Bayes factor and the prior odds of an event.
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

# Prior log odds of a push in one window: one in 12 s, as on a floor of slabs. Assumed.
EVENT_LOG_ODDS = math.log(1.0 / 50.0)
MAX_DISTURBED_FRACTION = 0.2  # of windows, and of measurements: more are a rough floor


def inflate_disturbed_windows(regression: Regression, rows: Array) -> tuple[list[Windows], int]:
    """Return windows with pushes as process noise where residuals (V,) show disturbed ones, and how many."""
    inflated, count = [], 0
    for windows, (scores, informations) in zip(regression.windows, regression.push_scores(rows), strict=True):
        covariance = windows.rounding.copy()
        measured = np.isfinite(windows.measured).sum() / (3.0 * len(covariance))
        fraction = MAX_DISTURBED_FRACTION * min(1.0, measured)
        for number in range(len(windows.signals.trucks)):
            pose = slice(3 * number, 3 * number + 3)
            information = PUSH_SIZE[:, None] * informations[:, pose, pose] * PUSH_SIZE
            log_odds = EVENT_LOG_ODDS + log_evidence(information, PUSH_SIZE * scores[:, pose], 1.0)
            pushed = np.flatnonzero(log_odds > max(0.0, float(np.quantile(log_odds, 1.0 - fraction))))
            covariance[pushed, pose, pose] += np.diag(PUSH_SIZE**2)
            count += len(pushed)
        inflated.append(replace(windows, rounding=covariance))
    return inflated, count


def power(scores: Array, informations: Array) -> Array:
    """Return the chi-squares (M,) of pushes with scores (M, 3) and informations (M, 3, 3)."""
    size = np.einsum("mii->m", informations)[:, None, None] / 3.0
    solved = np.linalg.solve(informations + (1e-9 * size + 1e-300) * np.eye(3), scores[:, :, None])[:, :, 0]
    return np.asarray(np.einsum("mi,mi->m", scores, solved))
