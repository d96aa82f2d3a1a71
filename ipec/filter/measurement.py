"""What a reading in steps says about a true value: the value lies within the step, and no more.

A joint that stays within its step along a whole straight line gives its angle a single time, not anew in
every sample. A filter that takes the resolution as white noise would average it away. So a reading cuts off
that part of the estimate's distribution which lies outside of its step, and mean and variance of the rest
are kept; where almost nothing lies outside, the reading changes nothing.
"""

import math

from omnimate.ipec.filter.records import (
    ERRORS,
    JOINT_A,
    JOINT_BIAS,
    STATES,
    WANDER,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.compiled_se2 import wrap

NOTHING_NEW = 0.9  # part inside of the step from which on a reading says nothing new
FLOOR = 0.2  # of half a step: what no averaging removes, the encoder's errors within a step
IMPOSSIBLE = 1e-6  # part inside below which the centre of the step is taken instead


@compiled
def density(value: float) -> float:
    """Return the standard normal density at a value."""
    return math.exp(-0.5 * value * value) / math.sqrt(2.0 * math.pi)


@compiled
def part_below(value: float) -> float:
    """Return the probability of a standard normal variable below a value."""
    return 0.5 * math.erfc(-value / math.sqrt(2.0))


@compiled
def cut(offset: float, variance: float, half: float) -> tuple[float, float]:
    """Return what remains of a normal distribution within a step: shift / variance, and information.

    The first is the shift of the mean divided by the variance, the second the decrease of the variance
    divided by the variance squared; both are 0 where the step says nothing new.

    Args:
        offset: Centre of the step minus the mean.
        variance: Variance of the distribution before the reading.
        half: Half the width of the step.
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
def expected_reading(mean: Array, number: int) -> float:
    """Return what joint_a (0), joint_b (1) or the link (2) reads with a mean `(19,)`, but for its wander."""
    expected: float = mean[JOINT_A + number] + mean[JOINT_BIAS + number]
    return expected


@compiled
def compare(state: FilterState, number: int) -> float:
    """Return reading minus estimate of joint_a (0), joint_b (1) or the link (2) [rad] or [m]."""
    expected = expected_reading(state.mean, number)
    if number < 2:
        return wrap(state.joint[number] - expected)
    return state.length - expected


@compiled
def innovation(state: FilterState, opened: OpenFilter, number: int) -> float:
    """Return the mean reading of a step minus what an open filter predicts [rad] or [m]."""
    mean: float = state.missed[number] / state.seen
    offset = opened.offset
    for error in range(ERRORS):
        mean -= opened.share[error, number] * offset[WANDER + error]
    return mean - expected_reading(offset, number)


@compiled
def find_scatter(settings: FilterSettings, state: FilterState) -> None:
    """Fill the variance of a step's mean readings, and half the steps that they are still sure within.

    Readings that change from sample to sample average their resolution away, as dither does: what is left of
    half a step falls by exp(-2 pi^2 variance / step^2), Widrow & Kollar, Quantization Noise (2008), ch. 19.
    """
    for number in range(3):
        half = settings.half[number]
        dither = 0.5 * state.jumps[number] / state.seen
        kept = math.exp(-0.5 * math.pi * math.pi * dither / (half * half))
        state.scatter[number] = state.blur[number] / state.seen + (FLOOR * half) ** 2
        state.sure[number] = half * kept


@compiled
def update(state: FilterState, opened: OpenFilter, number: int) -> None:
    """Take one reading of the linkage; keep its gain and the estimates of the lost travel.

    Args:
        state: Predicted estimate; its `shares` are changed.
        opened: Open filter, changed in place.
        number: 0 for joint_a, 1 for joint_b, 2 for the link.
    """
    true, bias = JOINT_A + number, JOINT_BIAS + number
    first, second = opened.share[0, number], opened.share[1, number]
    covariance, gain, shares = opened.covariance, opened.gain[number], state.shares
    for row in range(STATES):
        gain[row] = covariance[row, true] + covariance[row, bias]
        gain[row] += first * covariance[row, WANDER] + second * covariance[row, WANDER + 1]
    blur, half = state.scatter[number], state.sure[number]
    if number == opened.reading:
        blur += opened.vague
    variance = gain[true] + gain[bias] + first * gain[WANDER] + second * gain[WANDER + 1] + blur
    push, information = cut(innovation(state, opened, number), variance, half)
    gain[STATES], gain[STATES + 1] = push, information
    opened.updated[number] = 1 if information > 0.0 else 0
    if information <= 0.0:
        return
    for row in range(STATES):
        opened.offset[row] += gain[row] * push
        factor = gain[row] * information
        for column in range(STATES):
            covariance[row, column] -= factor * gain[column]
    for wheel in range(4):
        if opened.alert[wheel] > 0.0:
            share = shares[wheel, true] + shares[wheel, bias]
            share += first * shares[wheel, WANDER] + second * shares[wheel, WANDER + 1]
            opened.lost[wheel] += share * push
            for row in range(STATES):
                shares[wheel, row] -= share * information * gain[row]


@compiled
def _by_error(opened: OpenFilter, error: int, i: int, j: int) -> float:
    """Return what one size of what errs adds to the covariance of two innovations."""
    covariance, row = opened.covariance, WANDER + error
    mine, other = opened.share[error, i], opened.share[error, j]
    total = 0.0
    if mine != 0.0:
        total += mine * (covariance[row, JOINT_A + j] + covariance[row, JOINT_BIAS + j])
        for column in range(ERRORS):
            total += mine * opened.share[column, j] * covariance[row, WANDER + column]
    if other != 0.0:
        total += other * (covariance[JOINT_A + i, row] + covariance[JOINT_BIAS + i, row])
    return total


@compiled
def spread(state: FilterState, opened: OpenFilter) -> None:
    """Fill the covariance `(3, 3)` of the three innovations, with each step taken as uniform noise."""
    out, covariance = state.spread, opened.covariance
    for i in range(3):
        for j in range(3):
            out[i, j] = 0.0
            for row in (JOINT_A + i, JOINT_BIAS + i):
                for column in (JOINT_A + j, JOINT_BIAS + j):
                    out[i, j] += covariance[row, column]
            for error in range(ERRORS):
                out[i, j] += _by_error(opened, error, i, j)
        out[i, i] += state.sure[i] ** 2 / 3.0 + state.scatter[i]
        if i == opened.reading:
            out[i, i] += opened.vague
