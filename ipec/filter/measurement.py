"""Update by quantised readings: a reading bounds the true value to one quantisation step.

A joint that stays within one step along a straight line gives its angle once, not again in every sample; a
filter that models the resolution as white noise would average it away. So a reading truncates the estimate's
normal distribution to its step, and the mean and variance of the truncated distribution are used. A reading
with almost all of the distribution inside its step changes nothing.
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

MAX_INFORMATIVE_PROBABILITY = 0.9  # [1] of the step, above which a reading is not used (assumption)
INTERPOLATION_ERROR = 0.2  # [half steps] encoder error that averaging does not remove (assumption)
MIN_STEP_PROBABILITY = 1e-6  # [1] below it a uniform density over the step is used, for numerical stability


@compiled
def normal_density(value: float) -> float:
    """Return the standard normal density at a value."""
    return math.exp(-0.5 * value * value) / math.sqrt(2.0 * math.pi)


@compiled
def normal_probability(value: float) -> float:
    """Return the probability of a standard normal variable below a value."""
    return 0.5 * math.erfc(-value / math.sqrt(2.0))


@compiled
def truncate_normal(offset: float, variance: float, half: float) -> tuple[float, float]:
    """Return mean shift and variance decrease of a normal distribution truncated to a step.

    The shift is divided by the variance, the decrease by the variance squared; both are 0 if the step is not
    informative. `offset` is the centre of the step minus the mean, `half` its half-width.
    """
    sigma = math.sqrt(variance)
    low, high = (offset - half) / sigma, (offset + half) / sigma
    inside = normal_probability(high) - normal_probability(low)
    if inside > MAX_INFORMATIVE_PROBABILITY:
        return 0.0, 0.0
    if inside < MIN_STEP_PROBABILITY:
        total = variance + half * half / 3.0
        return offset / total, 1.0 / total
    shift = (normal_density(low) - normal_density(high)) / inside
    kept = 1.0 + (low * normal_density(low) - high * normal_density(high)) / inside - shift * shift
    return shift / sigma, (1.0 - kept) / variance


@compiled
def expected_reading(mean: Array, number: int) -> float:
    """Return the error-free reading of joint_a (0), joint_b (1) or link (2) at a mean `(19,)`."""
    expected: float = mean[JOINT_A + number] + mean[JOINT_BIAS + number]
    return expected


@compiled
def reading_residual(state: FilterState, number: int) -> float:
    """Return reading minus estimate of joint_a (0), joint_b (1) or the link (2) [rad] or [m]."""
    expected = expected_reading(state.mean, number)
    if number < 2:
        return wrap_angle(state.joint[number] - expected)
    return state.length - expected


@compiled
def innovation(state: FilterState, opened: OpenFilter, number: int) -> float:
    """Return the mean reading of a step minus what an open filter predicts [rad] or [m]."""
    mean: float = state.residual_sum[number] / state.linkage_samples
    return mean - product(opened.row[number], opened.offset)


@compiled
def fill_reading_variance(settings: FilterSettings, state: FilterState) -> None:
    """Fill variance and effective half-width of quantisation of a step's mean readings.

    Changes from sample to sample act as dither: the remaining quantisation error of a mean falls by
    exp(-2 pi^2 variance / step^2), Widrow & Kollar, Quantization Noise (2008), ch. 19.
    """
    for number in range(3):
        half = settings.half_count[number]
        dither = 0.5 * state.squared_changes[number] / state.linkage_samples
        kept = math.exp(-0.5 * math.pi * math.pi * dither / (half * half))
        state.mean_variance[number] = (
            state.reading_variance[number] / state.linkage_samples + (INTERPOLATION_ERROR * half) ** 2
        )
        state.half_width[number] = half * kept


@compiled
def apply_reading(state: FilterState, opened: OpenFilter, number: int) -> None:
    """Update an open filter by joint_a (0), joint_b (1) or the link (2); store gain and lost travel."""
    covariance, gain, row = opened.covariance, opened.gain[number], opened.row[number]
    shares = state.shares
    blur, half = state.mean_variance[number], state.half_width[number]
    if number == opened.reading:
        blur += opened.form_variance
    variance = blur + product(gain, row)
    push, information = truncate_normal(innovation(state, opened, number), variance, half)
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
    """Return the scalar product of the first `STATES` elements of two vectors."""
    total = 0.0
    for i in range(STATES):
        total += first[i] * second[i]
    return total


@compiled
def fill_rows(state: FilterState, opened: OpenFilter) -> None:
    """Fill the derivative of a step's mean readings by the states at its end.

    The mean refers to the middle of the step, so that half of the step's change is subtracted. The lost
    travel of a late wheel follows from mean speeds, which refer to the middle already.
    """
    half_span = 0.5 * (1.0 - 1.0 / state.linkage_samples)
    for number in range(3):
        row, true = opened.row[number], JOINT_A + number
        row[:] = 0.0
        for column in range(LINK, JOINT_BIAS):
            row[column] = -half_span * state.transition[true, column]
        row[true] += 1.0 + half_span
        row[JOINT_BIAS + number] = 1.0
        for error in range(ERRORS):
            if opened.form == LATE:
                row[WANDER + error] = 0.0
            row[WANDER + error] += opened.reading_sensitivity[error, number]


@compiled
def fill_innovation_covariance(state: FilterState, opened: OpenFilter) -> None:
    """Fill the covariances of the states with each reading, and that of the innovations `(3, 3)`.

    Quantisation is modelled as uniform noise here.
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
        out[number, number] += state.half_width[number] ** 2 / 3.0 + state.mean_variance[number]
        if number == opened.reading:
            out[number, number] += opened.form_variance
