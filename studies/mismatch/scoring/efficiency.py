"""Efficiency: how often an injected effect is found, against how strong it stands in the recording."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.scoring.judging import is_found

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from studies.mismatch.scoring.judging import Answer, Label

    Array = NDArray[np.float64]

STEPS = 50  # of Newton's method; some ten are enough where the fit has a limit
# Standard deviation of the slope's and the offset's prior: it decides only where all or none are found.
FLAT = 10.0


@dataclass(frozen=True, slots=True)
class Efficiency:
    """The efficiency of a tool, as a logistic function of the logarithm of the strength."""

    strength: Array  # strength of each injection, in standard deviations of its bound, shape `(N,)`
    found: NDArray[np.bool_]  # whether each was found, shape `(N,)`
    offset: float  # log odds at a strength of 1
    slope: float  # growth of the log odds by a factor e of strength

    @property
    def half(self) -> float:
        """The strength at which an effect is found half of the time; infinite where it grows by nothing."""
        if not len(self.found):
            return math.nan
        if not self.found.any() or self.slope <= 0.0:
            return math.inf
        return math.exp(-self.offset / self.slope)

    def at(self, strength: Array) -> Array:
        """Return the share that is found at strengths of any shape."""
        return np.asarray(1.0 / (1.0 + np.exp(-self.offset - self.slope * np.log(strength))))


def efficiency(labels: Mapping[str, Label], answers: Mapping[str, Answer]) -> Efficiency:
    """Return the efficiency over the injected cases, fitted by maximum likelihood."""
    pairs = [
        (label["strength"], is_found(label, answers[name]))
        for name, label in labels.items()
        if label["kind"] == "injected" and name in answers
    ]
    strength = np.array([strength for strength, _ in pairs], np.float64)
    found = np.array([found for _, found in pairs], bool)
    offset, slope = _logistic(np.log(strength), found)
    return Efficiency(strength, found, offset, slope)


def _logistic(at: Array, hit: NDArray[np.bool_]) -> tuple[float, float]:
    """Return offset and slope of a logistic regression, by Newton's method with a flat prior."""
    columns = np.stack([np.ones(len(at)), at], axis=1)
    weights = np.zeros(2)
    for _ in range(STEPS):
        share = 1.0 / (1.0 + np.exp(-columns @ weights))
        slope = columns.T @ (hit - share) - weights / FLAT**2
        curvature = (columns.T * (share * (1.0 - share))) @ columns + np.eye(2) / FLAT**2
        weights = weights + np.clip(np.linalg.solve(curvature, slope), -2.0, 2.0)
    return float(weights[0]), float(weights[1])
