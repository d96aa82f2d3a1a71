"""What a reading that counts in steps says about a true value: it lies within the step, no more.

A joint that stands still within its step for a whole straight line tells its angle once, not once per
sample: taken as white noise, its resolution would be averaged away that is really there. So a reading
cuts off that part of the estimate's distribution which lies outside of its step, and mean and variance
of the rest are kept; where almost nothing lies outside, it says nothing new.
"""

import math

import numpy as np

from ipec.filter_records import JOINT_A, JOINT_BIAS, STATES, FilterSettings, FilterState
from ipec.geometry import wrap
from vehicle.compiled import Array, compiled

NOTHING_NEW = 0.9  # part inside of the step from which on a reading says nothing new
IMPOSSIBLE = 1e-6  # part inside below which the centre of the step is taken instead


@compiled
def density(value: float) -> float:
    """Return the standard normal density."""
    return math.exp(-0.5 * value * value) / math.sqrt(2.0 * math.pi)


@compiled
def part_below(value: float) -> float:
    """Return the standard normal distribution."""
    return 0.5 * math.erfc(-value / math.sqrt(2.0))


@compiled
def cut(offset: float, variance: float, half: float) -> tuple[float, float]:
    """Return what remains of a normal distribution within a step: shift / variance, and information.

    The first is the mean's way over the variance, the second the part of the variance that goes over
    the variance squared; both 0 where the step says nothing new.

    Args:
        offset: of the step's centre from the mean.
        variance: before.
        half: of the step.
    """
    sigma = math.sqrt(variance)
    low, high = (offset - half) / sigma, (offset + half) / sigma
    inside = part_below(high) - part_below(low)
    if inside > NOTHING_NEW:
        return 0.0, 0.0
    if inside < IMPOSSIBLE:
        total = variance + half * half / 3.0
        return offset / total, 1.0 / total
    shift = (density(low) - density(high)) / inside
    kept = 1.0 + (low * density(low) - high * density(high)) / inside - shift * shift
    return shift / sigma, (1.0 - kept) / variance


@compiled
def innovation(state: FilterState, number: int) -> float:
    """Return reading minus prediction of joint_a, joint_b or link [rad] or [m]."""
    expected: float = state.mean[JOINT_A + number] + state.mean[JOINT_BIAS + number]
    if number < 2:
        return wrap(state.joint[number] - expected)
    return state.length - expected


@compiled
def update(settings: FilterSettings, state: FilterState, number: int, shares: Array) -> None:
    """Take one reading; leave its gain in the state, and the disturbances' estimates in it too.

    Args:
        settings: of the filter.
        state: predicted.
        number: 0 for joint_a, 1 for joint_b, 2 for the link.
        shares: `(4, 15)` covariance of each wheel's disturbance with the states, changed in place.
    """
    true, bias = JOINT_A + number, JOINT_BIAS + number
    covariance, gain = state.covariance, state.gain[number]
    for row in range(STATES):
        gain[row] = covariance[row, true] + covariance[row, bias]
    variance = gain[true] + gain[bias] + settings.blur[number]
    push, information = cut(innovation(state, number), variance, settings.half[number])
    gain[STATES], gain[STATES + 1] = push, information
    state.updated[number] = 1 if information > 0.0 else 0
    if information <= 0.0:
        return
    for row in range(STATES):
        state.mean[row] += gain[row] * push
        factor = gain[row] * information
        for column in range(STATES):
            covariance[row, column] -= factor * gain[column]
    for wheel in range(4):
        if state.alert[wheel] > 0.0:
            share = shares[wheel, true] + shares[wheel, bias]
            state.lost[wheel] += share * push
            for row in range(STATES):
                shares[wheel, row] -= share * information * gain[row]


@compiled
def spread(settings: FilterSettings, state: FilterState) -> Array:
    """Return the covariance `(3, 3)` of the three innovations, the steps taken as noise."""
    out = np.empty((3, 3))
    for one in range(3):
        for other in range(3):
            a, b = JOINT_A + one, JOINT_BIAS + one
            c, d = JOINT_A + other, JOINT_BIAS + other
            out[one, other] = (
                state.covariance[a, c]
                + state.covariance[a, d]
                + state.covariance[b, c]
                + state.covariance[b, d]
            )
        out[one, one] += settings.half[one] ** 2 / 3.0 + settings.blur[one]
    return out
