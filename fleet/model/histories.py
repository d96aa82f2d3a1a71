"""Histories: a robot's quantities day by day, and the nominal variation of robots of its type.

The nominal variation is estimated from the fleet itself (empirical Bayes), with medians, so that a few faulty
robots do not change it: the scatter of calibrations, mean and scatter of the wear, and the scatter from day
to day beyond the stated uncertainty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from omnimate.calib.distributions import MAD_TO_SIGMA
from omnimate.fleet.features import NO_JOINTS, Joints
from omnimate.fleet.segments import JOINT_NUMBERS, PARAMETERS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.se2 import Array

MIN_WEAR_DAYS = 5  # [days] of a history that are needed to estimate wear
# [1/day or rad/day] limit of wear, and its standard deviation while it is not known: tyres of 150 mm lose
# less than 0.1 mm in a week. A faster change is a fault, even if many robots of a small fleet have it.
MAX_WEAR = 1e-4
# [standard deviations of a day] limit of the scatter from day to day, for the same reason.
MAX_DAILY_SCATTER = 3.0
# [standard deviations of a day] lower limit of the scatter of the start among robots: a few robots do not
# determine it, and the start of a history must not be taken as a change.
MIN_START_SCATTER = 10.0


@dataclass(frozen=True, slots=True)
class RobotInformation:
    """The information of one recording on its robot, without the effect of the floor's places.

    The information is Fisher's on `PARAMETERS`, `(3, 3)`, the score is information times their estimate,
    `(3,)`; the day is YYYY-MM-DD.
    """

    robot: str
    kind: str
    day: str
    information: Array
    score: Array
    joints: Joints = NO_JOINTS


@dataclass(frozen=True, slots=True)
class History:
    """The quantities of one robot, day by day."""

    robot: str  # name of the robot
    kind: str  # type of the robot
    # names of the quantities, `(P,)`: `PARAMETERS`, and `JOINT_NUMBERS` with a linkage
    names: tuple[str, ...]
    dates: tuple[str, ...]  # dates, YYYY-MM-DD, `(D,)`
    days: Array  # days since the first date of the fleet, `(D,)`
    value: Array  # values [1 or rad], `(D, P)`
    covariance: Array  # their covariance, `(D, P, P)`; days are independent

    def sigma(self) -> Array:
        """Return the standard deviations of the values, `(D, P)`."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


def make_histories(recordings: Sequence[RobotInformation]) -> list[History]:
    """Return the histories of all robots; the recordings of one robot on one day are combined.

    A day whose recordings do not identify the robot's parameters is left out.
    """
    robots: dict[str, dict[str, list[RobotInformation]]] = {}
    for recording in recordings:
        robots.setdefault(recording.robot, {}).setdefault(recording.day, []).append(recording)
    first = min((date.fromisoformat(recording.day) for recording in recordings), default=date.min)
    histories = (_make_history(by_day, first) for _, by_day in sorted(robots.items()))
    return [history for history in histories if history is not None]


def _make_history(by_day: dict[str, list[RobotInformation]], first: date) -> History | None:
    """Return one robot's history since the fleet's first date; None if no day identifies its parameters."""
    solved = {day: _solve_day(recordings) for day, recordings in sorted(by_day.items())}
    known = {day: row for day, row in solved.items() if row is not None}
    if not known:
        return None
    size = max(len(value) for value, _ in known.values())
    known = {day: row for day, row in known.items() if len(row[0]) == size}
    robot = next(iter(by_day.values()))[0]
    return History(
        robot.robot,
        robot.kind,
        (*PARAMETERS, *JOINT_NUMBERS)[:size],
        tuple(known),
        np.array([float((date.fromisoformat(day) - first).days) for day in known]),
        np.array([value for value, _ in known.values()]),
        np.array([covariance for _, covariance in known.values()]),
    )


def _solve_day(recordings: Sequence[RobotInformation]) -> tuple[Array, Array] | None:
    """Return the quantities of a day `(P,)` and their covariance `(P, P)`; None if not identified."""
    information = np.sum([recording.information for recording in recordings], axis=0)
    if not np.isfinite(information).all() or np.linalg.cond(information) > 1e12:
        return None
    covariance = np.linalg.inv(information)
    value = covariance @ np.sum([recording.score for recording in recordings], axis=0)
    joints = [recording.joints for recording in recordings if len(recording.joints.bias)]
    if not joints:
        return value, covariance
    weights = np.array([joint.sigma**-2.0 for joint in joints])
    biases = np.array([joint.bias for joint in joints])
    bias_covariance = np.diag(1.0 / weights.sum(axis=0))
    mean_bias = (weights * biases).sum(axis=0) / weights.sum(axis=0)
    return np.concatenate([value, mean_bias]), block_diag(covariance, bias_covariance)


@dataclass(frozen=True, slots=True)
class NominalVariation:
    """The nominal variation of robots of one type, for each quantity [1 or rad], `(P,)`."""

    start: Array  # median of the robots' values on the first day
    start_variance: Array  # variance of these among robots
    wear: Array  # median of the robots' changes per day
    wear_variance: Array  # variance of these among robots
    daily: Array  # variance from day to day beyond the stated uncertainty
    sigma: Array  # median standard deviation of a value of one day

    def covariance(self, history: History) -> Array:
        """Return the covariance `(D P, D P)` of a healthy robot's history around its mean."""
        count, size = history.value.shape
        days = history.days
        joint = np.zeros((count, size, count, size))
        quantity = np.arange(size)
        joint[:, quantity, :, quantity] = (
            self.start_variance[:, np.newaxis, np.newaxis]
            + self.wear_variance[:, np.newaxis, np.newaxis] * days[:, np.newaxis] * days
        )
        diagonal = np.arange(count)
        joint[diagonal, :, diagonal, :] += history.covariance + np.diag(self.daily)
        return joint.reshape(count * size, count * size)

    def mean(self, history: History) -> Array:
        """Return the mean of a healthy robot's history, `(D, P)`."""
        return self.start + history.days[:, np.newaxis] * self.wear


def estimate_nominal_variation(histories: Sequence[History]) -> NominalVariation:
    """Return the nominal variation of robots of one type, estimated from their histories, at least one."""
    sigma = np.median(np.concatenate([history.sigma() for history in histories]), axis=0)
    lines, variances, residuals = zip(*map(_fit_line, histories), strict=True)
    values = np.array(lines)  # (R, 2, P): start, wear
    middle = np.median(values, axis=0)
    scatter = _robust_variance(values - middle)
    variance = np.maximum(scatter * _variance_margin(len(lines)) - np.median(variances, axis=0), 0.0)
    variance[0] = np.maximum(variance[0], (MIN_START_SCATTER * sigma) ** 2)
    if max(len(history.days) for history in histories) < MIN_WEAR_DAYS:
        middle[1], variance[1] = 0.0, MAX_WEAR**2
    middle[1] = np.clip(middle[1], -MAX_WEAR, MAX_WEAR)
    variance[1] = np.minimum(variance[1], MAX_WEAR**2)
    normalised = np.concatenate(residuals)
    ratio = _robust_variance(normalised) if len(normalised) > 1 else np.ones_like(sigma)
    daily = np.clip(ratio * _variance_margin(len(normalised)) - 1.0, 0.0, MAX_DAILY_SCATTER**2) * sigma**2
    return NominalVariation(middle[0], variance[0], middle[1], variance[1], daily, sigma)


def _fit_line(history: History) -> tuple[Array, Array, Array]:
    """Return start and wear `(2, P)`, their variances `(2, P)`, and normalised residuals [sigma] `(D, P)`.

    With fewer than `MIN_WEAR_DAYS` days the wear is 0. If the line fits all days exactly, there are no
    residuals, `(0, P)`.
    """
    count, size = history.value.shape
    order = 2 if count >= MIN_WEAR_DAYS else 1
    value, variance, residual = np.zeros((2, size)), np.zeros((2, size)), np.zeros((count, size))
    for number in range(size):
        sigma = np.sqrt(history.covariance[:, number, number])
        design = np.vander(history.days, order, increasing=True) / sigma[:, np.newaxis]
        scaled = history.value[:, number] / sigma
        covariance = np.linalg.pinv(design.T @ design)
        fitted = covariance @ design.T @ scaled
        value[:order, number], variance[:order, number] = fitted, np.diag(covariance)
        freedom = 1.0 - np.einsum("ni,ij,nj->n", design, covariance, design)
        residual[:, number] = (scaled - design @ fitted) / np.sqrt(np.maximum(freedom, 0.05))
    return value, variance, residual if count > order else residual[:0]


def _variance_margin(count: int) -> float:
    """Return one plus the relative standard error of a robust variance of `count` normal values.

    The efficiency of the median absolute deviation is 0.37 of that of the standard deviation.
    """
    return 1.0 + math.sqrt(2.0 / (0.37 * max(1, count)))


def _robust_variance(values: Array) -> Array:
    """Return the variance around 0 of values `(N, ...)`, from the median of their absolute values."""
    return np.asarray((MAD_TO_SIGMA * np.median(np.abs(values), axis=0)) ** 2, np.float64)
