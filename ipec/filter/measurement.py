"""What a reading in steps says about a true value: the value lies within the step, and no more.

A joint that stays within its step along a whole straight line gives its angle a single time, not anew in
every sample. A filter that takes the resolution as white noise would average it away. So a reading cuts off
that part of the estimate's distribution which lies outside of its step, and mean and variance of the rest
are kept; where almost nothing lies outside, the reading changes nothing.
"""

import math

from omnimate.ipec.filter.hypotheses import LATE
from omnimate.ipec.filter.records import (
    ERRORS,
    JOINT_A,
    JOINT_BIAS,
    LINK,
    STATES,
    WANDER,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.se2 import wrap_angle

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
    """Return what remains of a normal distribution within a step of half a width `half`.

    The first is the shift of the mean divided by the variance, the second the decrease of the variance
    divided by the variance squared; both are 0 where the step says nothing new. `offset` is the centre of the
    step minus the mean.
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
        return wrap_angle(state.joint[number] - expected)
    return state.length - expected


@compiled
def innovation(state: FilterState, opened: OpenFilter, number: int) -> float:
    """Return the mean reading of a step minus what an open filter predicts [rad] or [m]."""
    mean: float = state.missed[number] / state.seen
    return mean - product(opened.row[number], opened.offset)


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
def apply_reading(state: FilterState, opened: OpenFilter, number: int) -> None:
    """Update an open filter by joint_a (0), joint_b (1) or the link (2); keep gain and lost travel."""
    covariance, gain, row = opened.covariance, opened.gain[number], opened.row[number]
    shares = state.shares
    blur, half = state.scatter[number], state.sure[number]
    if number == opened.reading:
        blur += opened.vague
    variance = blur + product(gain, row)
    push, information = cut(innovation(state, opened, number), variance, half)
    gain[STATES], gain[STATES + 1] = push, information
    opened.updated[number] = 1 if information > 0.0 else 0
    if information <= 0.0:
        return
    for i in range(STATES):
        opened.offset[i] += gain[i] * push
        factor = gain[i] * information
        for j in range(STATES):
            covariance[i, j] -= factor * gain[j]
    for other in range(number + 1, 3):
        following = opened.gain[other]
        factor = information * product(gain, opened.row[other])
        for i in range(STATES):
            following[i] -= factor * gain[i]
    for wheel in range(4):
        if opened.alert[wheel] > 0.0:
            share = product(shares[wheel], row)
            opened.lost[wheel] += share * push
            for i in range(STATES):
                shares[wheel, i] -= share * information * gain[i]


@compiled
def product(first: Array, second: Array) -> float:
    """Return the product of two vectors of the states, of which only `STATES` elements count."""
    total = 0.0
    for i in range(STATES):
        total += first[i] * second[i]
    return total


@compiled
def fill_rows(state: FilterState, opened: OpenFilter) -> None:
    """Fill the derivative of a step's mean readings by the states at its end.

    The mean is of the middle of the step. What changes along the step has by then changed by half, and the
    derivative of what comes until the end is taken at the end. What a late wheel has lost is that of the
    middle already: it is told by the mean speed in the step.
    """
    late = 0.5 * (1.0 - 1.0 / state.seen)
    for number in range(3):
        row, true = opened.row[number], JOINT_A + number
        row[:] = 0.0
        for column in range(LINK, JOINT_BIAS):
            row[column] = -late * state.transition[true, column]
        row[true] += 1.0 + late
        row[JOINT_BIAS + number] = 1.0
        for error in range(ERRORS):
            if opened.form == LATE:
                row[WANDER + error] = 0.0
            row[WANDER + error] += opened.share[error, number]


@compiled
def spread(state: FilterState, opened: OpenFilter) -> None:
    """Fill the covariances of the states with each reading, and that of the innovations `(3, 3)`.

    Each step of a reading is taken as uniform noise.
    """
    out, covariance = state.spread, opened.covariance
    for number in range(3):
        gain = opened.gain[number]
        gain[:] = 0.0
        for column in range(LINK, STATES):
            factor = opened.row[number, column]
            if factor != 0.0:
                for i in range(STATES):
                    gain[i] += factor * covariance[column, i]
        for other in range(number + 1):
            out[number, other] = out[other, number] = product(gain, opened.row[other])
        out[number, number] += state.sure[number] ** 2 / 3.0 + state.scatter[number]
        if number == opened.reading:
            out[number, number] += opened.vague
