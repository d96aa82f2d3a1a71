"""Poses of both trucks and their uncertainty from the filter's mean and covariance; compiled."""

import math

import numpy as np

from omnimate.ipec.filter.records import JOINT_A, LENGTH, LINK, X, Y
from omnimate.vehicle.compiled import Array, compiled


@compiled
def fill_pose(mean: Array, covariance: Array, truck: int, pose: Array, sigma: Array) -> None:
    """Fill pose and standard deviations [m, m, rad] `(3,)` of truck a (0) or b (1).

    `mean` and `covariance` hold at least the first six states.
    """
    joint = JOINT_A + truck
    pose[0], pose[1], pose[2] = mean[X], mean[Y], mean[LINK] + mean[joint]
    cos = sin = 0.0  # by length of the link, for truck b
    if truck == 1:
        cos, sin = math.cos(mean[LINK]), math.sin(mean[LINK])
    ahead, aside = mean[LENGTH] * cos, mean[LENGTH] * sin
    pose[0] -= ahead
    pose[1] -= aside
    sigma[0] = coordinate_sigma(covariance, X, aside, -cos)
    sigma[1] = coordinate_sigma(covariance, Y, -ahead, -sin)
    heading = covariance[LINK, LINK] + 2.0 * covariance[LINK, joint] + covariance[joint, joint]
    sigma[2] = math.sqrt(max(heading, 0.0))


@compiled
def coordinate_sigma(covariance: Array, axis: int, by_link: float, by_length: float) -> float:
    """Return the standard deviation of a truck's coordinate X or Y [m].

    `by_link` and `by_length` are its derivatives by the link's heading [m/rad] and length.
    """
    total = covariance[axis, axis]
    total += 2.0 * (by_link * covariance[axis, LINK] + by_length * covariance[axis, LENGTH])
    total += by_link * (by_link * covariance[LINK, LINK] + 2.0 * by_length * covariance[LINK, LENGTH])
    return math.sqrt(max(total + by_length * by_length * covariance[LENGTH, LENGTH], 0.0))


@compiled
def add_axle_angle_variance(covariance: Array, mean: Array, origin: Array, variance: float) -> None:
    """Add to a covariance the unknown angle between truck a's direction of travel and its body.

    The start pose is that of the body: the angle rotates the path about `origin`, truck a's position at the
    start [m] `(2,)`, but not the body's heading. `variance` is that of the angle [rad^2].
    """
    if variance == 0.0:
        return
    by_angle = np.zeros(4)
    by_angle[X], by_angle[Y] = origin[1] - mean[Y], mean[X] - origin[0]
    by_angle[LINK], by_angle[JOINT_A] = 1.0, -1.0
    for row in range(4):
        for column in range(4):
            covariance[row, column] += variance * by_angle[row] * by_angle[column]


@compiled
def add_nonlinear_error(covariance: Array, error: float) -> None:
    """Add to a covariance the error of the position that is not linear in that of the heading [m]."""
    covariance[X, X] += error * error
    covariance[Y, Y] += error * error


@compiled
def fill_pose_jacobian(mean: Array, truck: int, rows: Array) -> None:
    """Fill the derivatives `(3, 19)` of a truck's pose by the states; `truck` is 0 for a, 1 for b."""
    rows[:] = 0.0
    rows[0, X] = rows[1, Y] = rows[2, LINK] = rows[2, JOINT_A + truck] = 1.0
    if truck == 1:
        cos, sin = math.cos(mean[LINK]), math.sin(mean[LINK])
        rows[0, LENGTH], rows[0, LINK] = -cos, mean[LENGTH] * sin
        rows[1, LENGTH], rows[1, LINK] = -sin, -mean[LENGTH] * cos
