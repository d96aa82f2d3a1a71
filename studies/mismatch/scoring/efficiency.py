"""Efficiency: how often an injected effect is found, against how strong it stands in the recording."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from studies.mismatch.engines.vocabulary import Array
from studies.mismatch.scoring.judging import Answer, Label, is_found

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
    hits = np.array([hit for _, hit in pairs], bool)
    offset, slope = _logistic(np.log(strength), hits)
    return Efficiency(strength, hits, offset, slope)


def _logistic(at: Array, hit: NDArray[np.bool_]) -> tuple[float, float]:
    """Return offset and slope of a logistic regression with a flat prior."""
    sign = np.where(hit, 1.0, -1.0)

    def cost(weights: Array) -> float:
        odds = weights[0] + weights[1] * at
        return float(np.logaddexp(0.0, -sign * odds).sum() + 0.5 * weights @ weights / FLAT**2)

    offset, slope = minimize(cost, np.zeros(2), tol=1e-9).x
    return float(offset), float(slope)
