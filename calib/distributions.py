"""Probabilities and quantiles for intervals and tests.

From `scipy.special`, because importing `scipy.stats` takes a second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import special

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.se2 import Array

MAD_TO_SIGMA = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


def normal_probability(deviate: float) -> float:
    """Return the probability that a standard normal number is below `deviate`."""
    return float(special.ndtr(deviate))


def normal_upper_limit(probability: float) -> float:
    """Return the number that a standard normal number exceeds with `probability`."""
    return float(-special.ndtri(probability))


def student_quantile(probability: float, freedom: float) -> float:
    """Return the quantile of Student's t; nan without a degree of freedom."""
    return float(special.stdtrit(freedom, probability))


def student_tail(ratio: float, freedom: float) -> float:
    """Return the probability that Student's t exceeds `ratio`."""
    return float(special.stdtr(freedom, -ratio))


def chi2_quantile(probability: float, freedom: float) -> float:
    """Return the quantile of chi^2."""
    return float(2.0 * special.gammaincinv(0.5 * freedom, probability))


def chi2_upper_limit(probability: float, freedom: Sequence[int]) -> Array:
    """Return the numbers that chi^2 exceeds with `probability`, one for each `freedom`."""
    return np.asarray(special.chdtri(freedom, probability), np.float64)


def fisher_tail(ratio: float, above: float, below: float) -> float:
    """Return the probability that Fisher's F with these degrees of freedom exceeds `ratio`."""
    return float(special.fdtrc(above, below, ratio))
