"""The likelihood of a chain of fixes between which a robot moved by its wheels: a Kalman filter, compiled.

Dead-reckoning errors accumulate, so the errors of poses at different times are correlated; the innovations of
a filter are the same data made white. Their derivatives by the parameters pass through the filter with them,
so that one pass gives whitened residuals and their Jacobian: generalised least squares without a large matrix
(the augmented filter of de Jong, 1991). A second pass, backwards, gives the auxiliary residual of each fix
and of each movement (de Jong & Penzer, 1998; Koopman, 1993): its difference from the prediction by all
others. From these follow the outliers and the score of every variance.

Its measurements are poses on SE(2); `ipec.filter` and `mismatch.noise.whitening` update by scalar readings
with sparse transitions of larger states, and share no code with it.
"""

import math
from typing import NamedTuple

import numpy as np

from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.matrices import complement, invert_into, product, sandwich
from omnimate.vehicle.se2 import rotate_xy, wrap_angle, write_composed, write_rotation, write_transport

START_POSITION_SIGMA = 10.0  # [m] of the position at the begin of a chain, before its first fix
START_HEADING_SIGMA = 3.0  # [rad] of the heading there


class Filtered(NamedTuple):
    """Result of the forward pass for M fixes and P parameters.

    The last axis `1 + P` holds a value and its derivatives by the parameters.
    """

    innovation: Array  # measured minus predicted x, y [m] in the body frame and theta [rad], `(M, 3, 1+P)`
    precision: Array  # inverse of the covariance of the innovation, `(M, 3, 3)`
    gain: Array  # gain of the filter, `(M, 3, 3)`
    carry: Array  # matrix that turns errors before the movement into errors after it, `(M, 3, 3)`
    heading: Array  # heading of the body frame in which the fix was compared [rad], `(M,)`


class Smoothed(NamedTuple):
    """Result of the backward pass: auxiliary residuals and their covariances."""

    fix: Array  # auxiliary residual of each fix, `(M, 3, 1+P)`
    fix_precision: Array  # covariance of the auxiliary residual of each fix, `(M, 3, 3)`
    step: Array  # auxiliary residual of the movement before each fix, `(M, 3, 1+P)`; first of a chain: zero
    step_precision: Array  # covariance of the auxiliary residual of each movement, `(M, 3, 3)`


@compiled
def write_residual(out: Array, measured: Array, pose: Array, lever: Array) -> None:
    """Write a measured pose minus that of the reference, which `lever` puts on the robot; body frame."""
    ahead, aside = rotate_xy(-pose[2], measured[0] - pose[0], measured[1] - pose[1])
    out[0], out[1] = ahead - lever[0], aside - lever[1]
    out[2] = wrap_angle(measured[2] - pose[2] - lever[2])
    for row in range(3):
        if math.isnan(out[row]):
            out[row] = 0.0


@compiled
def observation_matrix(lever: Array) -> Array:
    """Return the derivative `(3, 3)` of the reference's pose by the robot's pose, body frames."""
    observe = np.eye(3)
    observe[0, 2], observe[1, 2] = -lever[1], lever[0]
    return observe


@compiled
def filter_chains(
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
    """Filter chains of M fixes with P parameters; return the fields of `Filtered`.

    Arguments are the fields of `Chains` at given variances, but `first` is 1 where a fix begins a new chain,
    `process` `(M, 3, 3)` is the covariance of the movement in the body frame at its end, and `noise`
    `(M, 3, 3)` that of the measured poses in the world frame, huge where unknown.
    """
    count, size = len(measured), sensitivity.shape[2]
    innovation, precision = np.zeros((count, 3, 1 + size)), np.zeros((count, 3, 3))
    gain, carry, heading = np.zeros((count, 3, 3)), np.zeros((count, 3, 3)), np.zeros(count)
    observe = observation_matrix(lever)
    pose, moved, residual = np.zeros(3), np.zeros(3), np.zeros(3)
    covariance, before, spread = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    turn, mine, cross, rest = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    sensed, predicted, change = np.zeros((3, size)), np.zeros((3, size)), np.zeros((3, size))
    for k in range(count):
        if first[k] > 0.0:
            pose[:], sensed[:], covariance[:] = start[k], 0.0, 0.0
            covariance[0, 0] = covariance[1, 1] = START_POSITION_SIGMA * START_POSITION_SIGMA
            covariance[2, 2] = START_HEADING_SIGMA * START_HEADING_SIGMA
        else:
            write_transport(carry[k], right[k])
            write_composed(moved, left[k], pose)
            write_composed(pose, moved, right[k])
            before[:], covariance[:] = covariance, process[k]
            sandwich(covariance, carry[k], before)
            product(change, carry[k], sensed)
            sensed[:] = change + sensitivity[k]
        heading[k] = pose[2]
        write_rotation(turn, pose[2])
        mine[:] = 0.0
        sandwich(mine, turn, noise[k])
        spread[:] = mine
        sandwich(spread, observe, covariance)
        invert_into(precision[k], spread)
        write_residual(residual, measured[k], pose, lever)
        product(predicted, observe, sensed)
        predicted += effect[k]
        for row in range(3):
            innovation[k, row, 0] = residual[row]
            for column in range(size):
                innovation[k, row, 1 + column] = -predicted[row, column]
        product(cross, observe, covariance)
        product(gain[k], cross.T, precision[k])
        for row in range(3):
            moved[row] = 0.0
            for inner in range(3):
                moved[row] += gain[k, row, inner] * residual[inner]
        write_composed(pose, pose, moved)
        product(change, gain[k], predicted)
        sensed -= change
        complement(rest, gain[k], observe)
        before[:], covariance[:] = covariance, 0.0
        sandwich(covariance, rest, before)
        sandwich(covariance, gain[k], mine)
    return innovation, precision, gain, carry, heading


@compiled
def smooth_chains(
    first: Array, lever: Array, innovation: Array, precision: Array, gain: Array, carry: Array
) -> tuple[Array, Array, Array, Array]:
    """Smooth the results of `filter_chains`; return the fields of `Smoothed`."""
    count, columns = len(innovation), innovation.shape[2]
    fix, fix_precision = np.zeros((count, 3, columns)), np.zeros((count, 3, 3))
    step, step_precision = np.zeros((count, 3, columns)), np.zeros((count, 3, 3))
    later, other = np.zeros((3, columns)), np.zeros((3, columns))
    later_precision, rest = np.zeros((3, 3)), np.zeros((3, 3))
    observe = observation_matrix(lever)
    for back in range(count):
        k = count - 1 - back
        product(fix[k], precision[k], innovation[k])
        product(other, gain[k].T, later)
        fix_precision[k] = precision[k]
        sandwich(fix_precision[k], gain[k].T, later_precision)
        # Information on the pose from this fix is added to that from later ones.
        for row in range(3):
            for column in range(columns):
                fix[k, row, column] -= other[row, column]
        product(other, observe.T, fix[k])
        later += other
        complement(rest, gain[k], observe)
        spread = later_precision.copy()
        later_precision[:] = 0.0
        sandwich(later_precision, rest.T, spread)
        sandwich(later_precision, observe.T, precision[k])
        if first[k] > 0.0:
            later[:] = 0.0
            later_precision[:] = 0.0
        else:
            step[k], step_precision[k] = later, later_precision
            product(other, carry[k].T, later)
            later[:] = other
            spread[:] = later_precision
            later_precision[:] = 0.0
            sandwich(later_precision, carry[k].T, spread)
    return fix, fix_precision, step, step_precision


@compiled
def join_steps(
    start: Array, end: Array, increment: Array, jacobian: Array, noise: Array
) -> tuple[Array, Array, Array]:
    """Return the movements between fixes from single steps.

    Movement k joins the steps from `start[k]` to before `end[k]`, each `(M,)`. Steps are an increment `(N,
    3)`, its derivative by the parameters `(N, 3, P)`, and its covariance per unit variance of each source of
    noise `(N, C, 3, 3)`, both in the body frame at its end. So are the movements: `(M, 3)`, `(M, 3, P)` and
    `(C, M, 3, 3)`.
    """
    count, kinds, size = len(start), noise.shape[1], jacobian.shape[2]
    moved, sensitivity = np.zeros((count, 3)), np.zeros((count, 3, size))
    process = np.zeros((kinds, count, 3, 3))
    carry, before, change = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, size))
    for k in range(count):
        for step in range(int(start[k]), int(end[k])):
            write_transport(carry, increment[step])
            write_composed(moved[k], moved[k], increment[step])
            product(change, carry, sensitivity[k])
            for row in range(3):
                for column in range(size):
                    sensitivity[k, row, column] = change[row, column] + jacobian[step, row, column]
            for kind in range(kinds):
                before[:] = process[kind, k]
                process[kind, k] = noise[step, kind]
                sandwich(process[kind, k], carry, before)
    return moved, sensitivity, process
