"""What a reading in steps says about a true value: the value lies within the step, and no more.

A joint that stays within its step along a whole straight line gives its angle a single time, not anew in
every sample. A filter that takes the resolution as white noise would average it away. So a reading cuts off
that part of the estimate's distribution which lies outside of its step, and mean and variance of the rest
are kept; where almost nothing lies outside, the reading changes nothing.
"""

import math

import numpy as np

from omnimate.ipec.filter.records import (
    JOINT_A,
    JOINT_BIAS,
    STATES,
    WANDER,
    FilterSettings,
    FilterState,
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
    """Return what joint_a (0), joint_b (1) or the link (2) reads with a mean `(18,)`, but for its wander."""
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
def innovation(settings: FilterSettings, state: FilterState, hypothesis: int, number: int) -> float:
    """Return the mean reading of a step minus what an open filter predicts [rad] or [m]."""
    mean: float = state.missed[number] / state.seen
    offset = state.offset[hypothesis]
    wander: float = offset[WANDER] if settings.reading[hypothesis] == number else 0.0
    return mean - expected_reading(offset, number) - wander


@compiled
def scatter(settings: FilterSettings, state: FilterState, number: int) -> tuple[float, float]:
    """Return the variance of a step's mean reading, and half the step that it is still sure within.

    Readings that change from sample to sample average their resolution away, as dither does: what is left of
    half a step falls by exp(-2 pi^2 variance / step^2), Widrow & Kollar, Quantization Noise (2008), ch. 19.
    """
    half = settings.half[number]
    dither = 0.5 * state.jumps[number] / state.seen
    kept = math.exp(-0.5 * math.pi * math.pi * dither / (half * half))
    return state.blur[number] / state.seen + (FLOOR * half) ** 2, half * kept


@compiled
def update(settings: FilterSettings, state: FilterState, hypothesis: int, number: int, shares: Array) -> None:
    """Take one reading of the linkage; keep its gain and the estimates of the lost travel in the state.

    Args:
        settings: Settings of the filter.
        state: Predicted estimate; changed in place.
        hypothesis: Number of the hypothesis.
        number: 0 for joint_a, 1 for joint_b, 2 for the link.
        shares: Covariance of each wheel's lost travel with the states, shape `(4, 18)`; changed in place.
    """
    true, bias = JOINT_A + number, JOINT_BIAS + number
    wander = 1.0 if settings.reading[hypothesis] == number else 0.0
    covariance, gain = state.covariance[hypothesis], state.gain[hypothesis, number]
    for row in range(STATES):
        gain[row] = covariance[row, true] + covariance[row, bias] + wander * covariance[row, WANDER]
    blur, half = scatter(settings, state, number)
    variance = gain[true] + gain[bias] + wander * gain[WANDER] + blur
    push, information = cut(innovation(settings, state, hypothesis, number), variance, half)
    gain[STATES], gain[STATES + 1] = push, information
    state.updated[hypothesis, number] = 1 if information > 0.0 else 0
    if information <= 0.0:
        return
    for row in range(STATES):
        state.offset[hypothesis, row] += gain[row] * push
        factor = gain[row] * information
        for column in range(STATES):
            covariance[row, column] -= factor * gain[column]
    for wheel in range(4):
        if state.alert[hypothesis, wheel] > 0.0:
            share = shares[wheel, true] + shares[wheel, bias] + wander * shares[wheel, WANDER]
            state.lost[hypothesis, wheel] += share * push
            for row in range(STATES):
                shares[wheel, row] -= share * information * gain[row]


@compiled
def spread(settings: FilterSettings, state: FilterState, hypothesis: int) -> Array:
    """Return the covariance `(3, 3)` of the three innovations, with each step taken as uniform noise."""
    out, covariance = np.empty((3, 3)), state.covariance[hypothesis]
    wanders = settings.reading[hypothesis]
    for i in range(3):
        for j in range(3):
            out[i, j] = 0.0
            for row in (JOINT_A + i, JOINT_BIAS + i):
                for column in (JOINT_A + j, JOINT_BIAS + j):
                    out[i, j] += covariance[row, column]
            if wanders == i:
                out[i, j] += covariance[WANDER, JOINT_A + j] + covariance[WANDER, JOINT_BIAS + j]
            if wanders == j:
                out[i, j] += covariance[JOINT_A + i, WANDER] + covariance[JOINT_BIAS + i, WANDER]
            if wanders == i == j:
                out[i, j] += covariance[WANDER, WANDER]
        blur, half = scatter(settings, state, i)
        out[i, i] += half * half / 3.0 + blur
    return out
