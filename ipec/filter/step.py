"""One sample of the filter: predict; at the end of a step find disturbances, update, and mix; compiled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.disturbed_wheels import STEP_LENGTH, detect_disturbed_inputs, fill_noise_levels
from omnimate.ipec.filter.forms import fill_sensitivities, fill_speeds
from omnimate.ipec.filter.measurement import (
    apply_reading,
    expected_reading,
    fill_reading_variance,
    fill_rows,
    reading_residual,
)
from omnimate.ipec.filter.mixture import move_to_mixture
from omnimate.ipec.filter.prediction import (
    decay_error,
    differentiate,
    fill_input_variance,
    predict_covariance,
    predict_mean,
)
from omnimate.ipec.filter.records import (
    ERRORS,
    HYPOTHESIS_COUNT,
    INPUTS,
    JOINT_A,
    JOINT_BIAS,
    LINK,
    POSE,
    WANDER,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.ipec.readings import convert_counts
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

DISTURBED_STEP_LENGTH = 0.0125  # [m] the same while a wheel is disturbed: a quarter of a bump of 0.05 m
# [1/sample] Forgetting factor of the readings' noise: 3 s at 15 ms (assumption).
READING_NOISE_RATE = 1.0 / 200.0


@compiled
def initialise_linkage(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Initialise joints and link from a first reading; before, state `LINK` is the heading of truck a."""
    for number in range(3):
        reading = state.joint[number] if number < 2 else state.length
        state.mean[JOINT_A + number] = reading - state.mean[JOINT_BIAS + number]
    begin_step(state)
    _initialise_covariance(settings, state, state.covariance, np.zeros(ERRORS), np.zeros((ERRORS, 3)))
    for hypothesis in range(HYPOTHESIS_COUNT):
        opened = filters[hypothesis]
        fill_sensitivities(state, opened)
        _initialise_covariance(
            settings, state, opened.covariance, opened.variance, opened.reading_sensitivity
        )
    state.mean[LINK] -= state.mean[JOINT_A]
    state.is_linked = 1
    begin_step(state)


@compiled
def _initialise_covariance(
    settings: FilterSettings, state: FilterState, covariance: Array, variance: Array, shares: Array
) -> None:
    """Fill a covariance `(19, 19)` after the first reading of the linkage.

    `variance` `(2,)` is that of the error's sizes; `shares` `(2, 3)` are the derivatives of joint_a, joint_b
    and the link by them.
    """
    for error in range(ERRORS):
        covariance[WANDER + error, WANDER + error] = variance[error]
    for number in range(3):
        true = JOINT_A + number
        covariance[true, true] = settings.half_count[number] ** 2 / 3.0 + state.reading_variance[number]
        _correlate_with_error(covariance, true, JOINT_BIAS + number, 1.0)
        for error in range(ERRORS):
            _correlate_with_error(covariance, true, WANDER + error, shares[error, number])
    covariance[LINK, LINK] += covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_A] = covariance[JOINT_A, LINK] = -covariance[JOINT_A, JOINT_A]
    for error in (JOINT_BIAS, WANDER, WANDER + 1):
        covariance[LINK, error] = covariance[error, LINK] = -covariance[JOINT_A, error]


@compiled
def widen_first_reading(settings: FilterSettings, state: FilterState, covariance: Array) -> None:
    """Add to a covariance `(19, 19)` what the first step has shown of the noise of the first reading."""
    for number in range(3):
        more = max(0.0, state.reading_variance[number] - settings.half_count[number] ** 2 / 3.0)
        covariance[JOINT_A + number, JOINT_A + number] += more
        if number == 0:
            covariance[LINK, LINK] += more
            covariance[LINK, JOINT_A] -= more
            covariance[JOINT_A, LINK] -= more


@compiled
def _correlate_with_error(covariance: Array, true: int, error: int, share: float) -> None:
    """Correlate a true value with an error in a covariance `(19, 19)`: true = reading - share x error."""
    covariance[true, true] += share * share * covariance[error, error]
    covariance[true, error] = covariance[error, true] = -share * covariance[error, error]


@compiled
def begin_step(state: FilterState) -> None:
    """Reset the sums of a step."""
    state.step_start[:] = state.mean[LINK : LINK + 4]
    state.step_travel[:] = 0.0
    state.step_distance[:] = 0.0
    state.residual_sum[:] = 0.0
    state.squared_changes[:] = 0.0
    state.samples = state.linkage_samples = 0


@compiled
def accumulate(settings: FilterSettings, state: FilterState) -> None:
    """Add the residuals of one sample to the sums of the step, and update the readings' noise."""
    state.linkage_samples += 1
    state.readings += 1
    rate = max(READING_NOISE_RATE, 1.0 / state.readings)  # at first, the mean of all readings so far
    for number in range(3):
        residual = reading_residual(state, number)
        change = residual - state.last_residual[number]
        # White noise makes successive changes negatively correlated; motion does not.
        noise = -change * state.residual_change[number]
        if rate == READING_NOISE_RATE:  # an outlier counts little, once the noise is known
            most = 9.0 * max(state.reading_variance[number], settings.half_count[number] ** 2 / 3.0)
            noise = min(max(noise, -most), most)
        variance = state.reading_variance[number]
        state.reading_variance[number] = max(0.0, variance + rate * (noise - variance))
        state.residual_sum[number] += residual
        state.squared_changes[number] += change * change
        state.last_residual[number], state.residual_change[number] = residual, change


@compiled
def is_step_complete(state: FilterState) -> bool:
    """Return whether the step is long enough for an update; steps are shorter while a wheel is distrusted."""
    return bool(state.step_distance.max() >= (DISTURBED_STEP_LENGTH if state.is_disturbed else STEP_LENGTH))


@compiled
def update(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Predict an open filter over a step and update it with the readings."""
    opened.nis = math.nan
    opened.lost[:] = 0.0
    opened.updated[:] = 0
    fill_sensitivities(state, opened)
    fill_noise_levels(settings, state, opened)
    fill_input_variance(settings, state, opened)
    predict_covariance(settings, state, opened)
    decay_error(state, opened)
    rolled, alert = 0.25 * state.step_distance.sum(), opened.alert
    for number in range(INPUTS):
        alert[number] = max(0.0, alert[number] - rolled)
    if state.linkage_samples == 0:
        return
    fill_rows(state, opened)
    detect_disturbed_inputs(settings, state, opened)
    shares = state.shares
    shares[:] = 0.0
    for wheel in range(4):
        if alert[wheel] > 0.0:
            for row in range(POSE):
                shares[wheel, row] = opened.input_variance[wheel] * state.inputs[row, wheel]
    for number in range(3):
        apply_reading(state, opened, number)
    for wheel in range(4):
        opened.lost[wheel] *= -math.copysign(1.0, state.step_travel[wheel])


@compiled
def finish_step(settings: Record, states: Record, filters: Record, moves: Array) -> None:
    """End a step in which the robot has moved: predict covariances, update, and mix.

    After the first reading of the linkage the open filters are initialised by it instead. `settings` and
    `states` are records `(1,)`; estimate and open filters `(H,)` are changed in place, `moves` is as in
    `move_to_mixture`.
    """
    state = states[0]
    if not state.is_linked and state.linked:
        initialise_linkage(settings[0], state, filters)
    if state.step_distance.sum() == 0.0:
        return
    state.predicted = 1
    state.last_step_travel[:] = state.step_travel
    differentiate(settings[0], state)
    fill_speeds(settings[0], state)
    if state.linkage_samples > 0:
        fill_reading_variance(settings[0], state)
    for hypothesis in range(HYPOTHESIS_COUNT):
        if filters[hypothesis].is_active:
            if state.mixture_count == 0:
                widen_first_reading(settings[0], state, filters[hypothesis].covariance)
            update(settings[0], state, filters[hypothesis])
    before = np.empty(3)
    for number in range(3):
        before[number] = expected_reading(state.mean, number)
    move_to_mixture(settings[0], state, filters, moves)
    for number in range(3):
        state.last_residual[number] -= expected_reading(state.mean, number) - before[number]
    begin_step(state)


@compiled
def predict(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> bool:
    """Move the estimate by one sample; return whether `finish_step` has to follow.

    The trucks move only if all four wheels were read; counts and presence `(7,)` are in the order of
    `CHANNELS`. Settings and estimate are as in `finish_step`.
    """
    state = states[0]
    state.shift[:] = 0.0
    state.predicted = 0
    if not (present[0] and present[1] and present[2] and present[3]):
        return False
    convert_counts(settings[0], state, counts, present)
    if not state.is_linked:
        return bool(state.linked)
    if not state.moved[0]:
        return False
    predict_mean(settings[0], state)
    state.samples += 1
    for wheel in range(4):
        state.step_travel[wheel] += state.travel[wheel]
        state.step_distance[wheel] += abs(state.travel[wheel])
    if state.linked:
        accumulate(settings[0], state)
    return is_step_complete(state)
