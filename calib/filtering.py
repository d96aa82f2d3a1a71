"""The likelihood of a chain of fixes between which a robot moved by its wheels: a Kalman filter, compiled.

Dead-reckoning errors accumulate, so errors of poses at different times are correlated; the innovations of
a filter are the same data made white. Their derivatives with respect to the parameters go through the filter
with them, so that one pass gives a whitened residual and its Jacobian: generalised least squares without
a large matrix (the augmented filter of de Jong, 1991). A second pass, backwards, gives each fix's and each
step's auxiliary residual (de Jong & Penzer, 1998; Koopman, 1993): what it differs by from all the others.
From these follow the outliers and the score of every variance.
"""

import math
from typing import NamedTuple

import numpy as np

from calib.matrices import (
    inverse,
    join,
    product,
    product_of_transposed,
    rotation,
    sandwich,
    sandwich_of_transposed,
    transport,
)
from vehicle.compiled import Array, compiled

FAR = 10.0  # [m] where a chain begins is not known before its first fix
AROUND = 3.0  # [rad] likewise


class Filtered(NamedTuple):
    """What the pass forwards leaves for M fixes and P parameters.

    The last axis `1 + P` holds a value and its derivatives with respect to the parameters.

    Attributes:
        innovation: (M, 3, 1+P) measured minus predicted: x, y [m] in the body frame, theta [rad].
        precision: (M, 3, 3) inverse of its covariance.
        gain: (M, 3, 3) of the filter.
        carry: (M, 3, 3) how errors before the movement become errors after it.
        heading: (M,) of the body frame in which the fix was compared [rad].
    """

    innovation: Array
    precision: Array
    gain: Array
    carry: Array
    heading: Array


class Smoothed(NamedTuple):
    """What the pass backwards makes of it: auxiliary residuals and their covariances.

    Attributes:
        fix: (M, 3, 1+P) of each fix.
        fix_precision: (M, 3, 3) its covariance.
        step: (M, 3, 1+P) of the movement before each fix; zero at a chain's first.
        step_precision: (M, 3, 3) its covariance.
    """

    fix: Array
    fix_precision: Array
    step: Array
    step_precision: Array


@compiled
def compare(out: Array, measured: Array, pose: Array, lever: Array) -> None:
    """Write a measured pose minus that of the reference, which `lever` puts on the robot; body frame."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    east, north = measured[0] - pose[0], measured[1] - pose[1]
    out[0] = cos * east + sin * north - lever[0]
    out[1] = -sin * east + cos * north - lever[1]
    angle = measured[2] - pose[2] - lever[2]
    out[2] = angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)
    for row in range(3):
        if math.isnan(out[row]):
            out[row] = 0.0


@compiled
def observation(lever: Array) -> Array:
    """Return how an error of the robot's pose shows in that of the reference, `(3, 3)`."""
    observe = np.eye(3)
    observe[0, 2], observe[1, 2] = -lever[1], lever[0]
    return observe


@compiled
def forwards(
    first: Array,
    start: Array,
    left: Array,
    right: Array,
    sensitivity: Array,
    process: Array,
    measured: Array,
    noise: Array,
    lever: Array,
    effect: Array,
) -> tuple[Array, Array, Array, Array, Array]:
    """Filter chains of M fixes with P parameters; returns the fields of `Filtered`.

    Args:
        first: (M,) 1 where a fix begins a new chain.
        start: (M, 3) where a chain begins, roughly; used where `first`.
        left: (M, 3) increment before the pose: pose = left (+) pose before (+) right.
        right: (M, 3) increment of the body.
        sensitivity: (M, 3, P) derivative of the movement, body frame at its end.
        process: (M, 3, 3) covariance of the movement, body frame at its end.
        measured: (M, 3) poses of the reference; nan where unknown.
        noise: (M, 3, 3) their covariance in the world frame; huge where unknown.
        lever: (3,) pose of the reference on the robot.
        effect: (M, 3, P) derivative of the reference's pose, body frame.
    """
    count, size = len(measured), sensitivity.shape[2]
    innovation, precision = np.zeros((count, 3, 1 + size)), np.zeros((count, 3, 3))
    gain, carry, heading = np.zeros((count, 3, 3)), np.zeros((count, 3, 3)), np.zeros(count)
    observe = observation(lever)
    pose, moved, residual = np.zeros(3), np.zeros(3), np.zeros(3)
    covariance, before, spread = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    turn, mine, cross, rest = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    sensed, predicted, change = np.zeros((3, size)), np.zeros((3, size)), np.zeros((3, size))
    for k in range(count):
        if first[k] > 0.0:
            pose[:], sensed[:], covariance[:] = start[k], 0.0, 0.0
            covariance[0, 0] = covariance[1, 1] = FAR * FAR
            covariance[2, 2] = AROUND * AROUND
        else:
            transport(carry[k], right[k])
            join(moved, left[k], pose)
            join(pose, moved, right[k])
            before[:], covariance[:] = covariance, process[k]
            sandwich(covariance, carry[k], before)
            product(change, carry[k], sensed)
            sensed[:] = change + sensitivity[k]
        heading[k] = pose[2]
        rotation(turn, pose[2])
        mine[:] = 0.0
        sandwich(mine, turn, noise[k])
        spread[:] = mine
        sandwich(spread, observe, covariance)
        inverse(precision[k], spread)
        compare(residual, measured[k], pose, lever)
        product(predicted, observe, sensed)
        predicted += effect[k]
        for row in range(3):
            innovation[k, row, 0] = residual[row]
            for column in range(size):
                innovation[k, row, 1 + column] = -predicted[row, column]
        product_of_transposed(cross, observe.T, covariance)
        product_of_transposed(gain[k], cross, precision[k])
        for row in range(3):
            moved[row] = 0.0
            for inner in range(3):
                moved[row] += gain[k, row, inner] * residual[inner]
        join(pose, pose, moved)
        product(change, gain[k], predicted)
        sensed -= change
        product(rest, gain[k], observe)
        rest[:] = -rest
        for row in range(3):
            rest[row, row] += 1.0
        before[:], covariance[:] = covariance, 0.0
        sandwich(covariance, rest, before)
        sandwich(covariance, gain[k], mine)
    return innovation, precision, gain, carry, heading


@compiled
def backwards(
    first: Array, lever: Array, innovation: Array, precision: Array, gain: Array, carry: Array
) -> tuple[Array, Array, Array, Array]:
    """Smooth what `forwards` left; returns the fields of `Smoothed`."""
    count, columns = len(innovation), innovation.shape[2]
    fix, fix_precision = np.zeros((count, 3, columns)), np.zeros((count, 3, 3))
    step, step_precision = np.zeros((count, 3, columns)), np.zeros((count, 3, 3))
    later, other = np.zeros((3, columns)), np.zeros((3, columns))
    later_precision, rest = np.zeros((3, 3)), np.zeros((3, 3))
    observe = observation(lever)
    for back in range(count):
        k = count - 1 - back
        product(fix[k], precision[k], innovation[k])
        product_of_transposed(other, gain[k], later)
        fix_precision[k] = precision[k]
        sandwich_of_transposed(fix_precision[k], gain[k], later_precision)
        # What the fix says of the pose, after what later ones say: observe' (innovation part) + later.
        for row in range(3):
            for column in range(columns):
                fix[k, row, column] -= other[row, column]
        product_of_transposed(other, observe, fix[k])
        later += other
        product(rest, gain[k], observe)
        rest[:] = -rest
        for row in range(3):
            rest[row, row] += 1.0
        spread = later_precision.copy()
        later_precision[:] = 0.0
        sandwich_of_transposed(later_precision, rest, spread)
        sandwich_of_transposed(later_precision, observe, precision[k])
        if first[k] > 0.0:
            later[:] = 0.0
            later_precision[:] = 0.0
        else:
            step[k], step_precision[k] = later, later_precision
            product_of_transposed(other, carry[k], later)
            later[:] = other
            spread[:] = later_precision
            later_precision[:] = 0.0
            sandwich_of_transposed(later_precision, carry[k], spread)
    return fix, fix_precision, step, step_precision


@compiled
def accumulate(
    start: Array, end: Array, increment: Array, jacobian: Array, noise: Array
) -> tuple[Array, Array, Array]:
    """Join steps to the movements between fixes.

    Args:
        start: (M,) first step of each movement.
        end: (M,) the step after its last.
        increment: (N, 3) of each step.
        jacobian: (N, 3, P) its derivative, body frame at its end.
        noise: (N, C, 3, 3) its covariance for each kind of noise, per unit variance, likewise.

    Returns:
        The movements `(M, 3)`, derivatives `(M, 3, P)` and covariances `(C, M, 3, 3)` likewise.
    """
    count, kinds, size = len(start), noise.shape[1], jacobian.shape[2]
    moved, sensitivity = np.zeros((count, 3)), np.zeros((count, 3, size))
    process = np.zeros((kinds, count, 3, 3))
    carry, before, change = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, size))
    for k in range(count):
        for step in range(int(start[k]), int(end[k])):
            transport(carry, increment[step])
            join(moved[k], moved[k], increment[step])
            product(change, carry, sensitivity[k])
            for row in range(3):
                for column in range(size):
                    sensitivity[k, row, column] = change[row, column] + jacobian[step, row, column]
            for kind in range(kinds):
                before[:] = process[kind, k]
                process[kind, k] = noise[step, kind]
                sandwich(process[kind, k], carry, before)
    return moved, sensitivity, process
