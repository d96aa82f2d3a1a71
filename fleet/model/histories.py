"""Histories: a robot's numbers day by day, and what is ordinary for robots of its type.

What is ordinary is learned from the fleet itself (empirical Bayes), robustly, so that the few sick robots do
not change it: how far calibrations scatter, how fast robots of this type wear and how differently, and how
much more the numbers scatter from day to day than their own uncertainty says.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.se2 import Array

LINE = 5  # days from which on wear is learned
# [1/day or rad/day] of wear, as long as it is not known: tyres of 150 mm lose below 0.1 mm in a week. What
# changes faster is no ordinary wear, however many robots of a small fleet do so.
UNKNOWN_WEAR = 1e-4
# [standard deviations of a day] of ordinary scatter from day to day, at most, for the same reason.
MOST_DAILY = 3.0
# [standard deviations of a day] of what robots differ from their files at least: where a robot starts is no
# news, and few robots say little of how much they differ.
CALIBRATED = 10.0
_NORMAL = 1.4826  # standard deviation of a normal distribution, of its median absolute deviation


@dataclass(frozen=True, slots=True)
class History:
    """What the days say of one robot.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot.
        names: Names of the numbers.
        dates: Dates, YYYY-MM-DD, `(D,)`.
        days: Days since the first date of the fleet, `(D,)`.
        value: Values [1 or rad], `(D, P)`.
        covariance: Their covariance, `(D, P, P)`; days are independent.
    """

    robot: str
    kind: str
    names: tuple[str, ...]
    dates: tuple[str, ...]
    days: Array
    value: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class Ordinary:
    """What is ordinary for a type of robots; each `(P,)`.

    Attributes:
        start: Mean on the first day.
        start_variance: Scatter of that among robots.
        wear: Mean change per day.
        wear_variance: Scatter of that among robots.
        daily: Variance from day to day beyond what the numbers' own uncertainty says.
        sigma: Median standard deviation of a day's number.
    """

    start: Array
    start_variance: Array
    wear: Array
    wear_variance: Array
    daily: Array
    sigma: Array

    def covariance(self, history: History) -> Array:
        """Return the covariance `(D P, D P)` of a healthy robot's history around its mean."""
        count, size = history.value.shape
        days = history.days
        joint = np.zeros((count, size, count, size))
        at = np.arange(size)
        joint[:, at, :, at] = (
            self.start_variance[:, np.newaxis, np.newaxis]
            + self.wear_variance[:, np.newaxis, np.newaxis] * days[:, np.newaxis] * days
        )
        each = np.arange(count)
        joint[each, :, each, :] += history.covariance + np.diag(self.daily)
        return joint.reshape(count * size, count * size)

    def mean(self, history: History) -> Array:
        """Return the mean of a healthy robot's history, `(D, P)`."""
        return self.start + history.days[:, np.newaxis] * self.wear


def ordinary(histories: Sequence[History]) -> Ordinary:
    """Return what is ordinary for robots of one type, from their histories."""
    sigma = np.median(
        np.concatenate([np.sqrt(np.diagonal(single.covariance, axis1=1, axis2=2)) for single in histories]),
        axis=0,
    )
    lines = [_line(single) for single in histories]
    values = np.array([line.value for line in lines])  # (R, 2, P): start, wear
    variances = np.median([line.variance for line in lines], axis=0)
    middle = np.median(values, axis=0)
    scatter = _robust_variance(values - middle)
    own = np.maximum(scatter * _doubt(len(lines)) - variances, 0.0)
    own[0] = np.maximum(own[0], (CALIBRATED * sigma) ** 2)
    if max(len(single.days) for single in histories) < LINE:
        middle[1], own[1] = 0.0, UNKNOWN_WEAR**2
    middle[1] = np.clip(middle[1], -UNKNOWN_WEAR, UNKNOWN_WEAR)
    own[1] = np.minimum(own[1], UNKNOWN_WEAR**2)
    left = np.concatenate([line.left for line in lines])
    ratio = _robust_variance(left) if len(left) > 1 else np.ones_like(sigma)
    daily = np.clip(ratio * _doubt(len(left)) - 1.0, 0.0, MOST_DAILY**2) * sigma**2
    return Ordinary(middle[0], own[0], middle[1], own[1], daily, sigma)


@dataclass(frozen=True, slots=True)
class _Line:
    """A line through a history: start and wear with their variances `(2, P)`, and what is left of each day.

    `left` is in standard deviations, `(D, P)`.
    """

    value: Array
    variance: Array
    left: Array


def _line(history: History) -> _Line:
    """Return the line through each number of a history, or the mean where there are few days."""
    count, size = history.value.shape
    order = 2 if count >= LINE else 1
    value, variance, left = np.zeros((2, size)), np.zeros((2, size)), np.zeros((count, size))
    for number in range(size):
        sigma = np.sqrt(history.covariance[:, number, number])
        design = np.vander(history.days, order, increasing=True) / sigma[:, np.newaxis]
        seen = history.value[:, number] / sigma
        covariance = np.linalg.pinv(design.T @ design)
        fitted = covariance @ design.T @ seen
        value[:order, number], variance[:order, number] = fitted, np.diag(covariance)
        freedom = 1.0 - np.einsum("ni,ij,nj->n", design, covariance, design)
        left[:, number] = (seen - design @ fitted) / np.sqrt(np.maximum(freedom, 0.05))
    return _Line(value, variance, left if count > order else left[:0])


def _doubt(count: int) -> float:
    """Return how much larger than a robust estimate from some values a variance may be: one standard error.

    The median absolute deviation has 0.37 of the efficiency of the standard deviation.
    """
    return 1.0 + math.sqrt(2.0 / (0.37 * max(1, count)))


def _robust_variance(values: Array) -> Array:
    """Return the variance around 0 of values `(N, ...)`, from the median of their absolute values."""
    return np.asarray((_NORMAL * np.median(np.abs(values), axis=0)) ** 2, np.float64)
