"""One sample of the filter: predict, find disturbed wheels, and update by the linkage's readings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.disturbed_wheels import find_disturbed
from omnimate.ipec.filter.measurement import update
from omnimate.ipec.filter.prediction import find_input_variance, predict_covariance, predict_mean
from omnimate.ipec.filter.records import JOINT_A, JOINT_BIAS, LINK, POSE, STATES, FilterSettings, FilterState
from omnimate.ipec.readings import sense
from omnimate.vehicle.compiled import IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray


@compiled
def place(settings: FilterSettings, state: FilterState) -> None:
    """Read the linkage for the first time; until then the heading of truck a stands for the link's."""
    covariance = state.covariance
    for number in range(3):
        true, bias = JOINT_A + number, JOINT_BIAS + number
        reading = state.joint[number] if number < 2 else state.length
        state.mean[true] = reading - state.mean[bias]
        variance = settings.half[number] ** 2 / 3.0 + settings.blur[number] + covariance[bias, bias]
        covariance[true, true] = variance
        covariance[true, bias] = covariance[bias, true] = -covariance[bias, bias]
    state.mean[LINK] -= state.mean[JOINT_A]
    covariance[LINK, LINK] += covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_A] = covariance[JOINT_A, LINK] = -covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_BIAS] = covariance[JOINT_BIAS, LINK] = covariance[JOINT_BIAS, JOINT_BIAS]
    state.placed = 1


@compiled
def take(settings: FilterSettings, state: FilterState) -> None:
    """Take the three readings of the linkage, and what they say about the distrusted wheels."""
    find_disturbed(settings, state)
    shares = np.zeros((4, STATES))
    for wheel in range(4):
        if state.alert[wheel] > 0.0:
            for row in range(POSE):
                shares[wheel, row] = state.input_variance[wheel] * state.inputs[row, wheel]
    for number in range(3):
        update(settings, state, number, shares)
    for wheel in range(4):
        state.lost[wheel] *= -math.copysign(1.0, state.travel[wheel])


@compiled
def advance(
    settings: FilterSettings, state: FilterState, counts: IntArray, present: NDArray[np.bool_]
) -> None:
    """Take one sample in place; the trucks move only where all four wheels were read.

    Args:
        settings: Settings of the filter.
        state: Estimate before the sample; changed to the estimate after it.
        counts: Counts in the order of `CHANNELS`, shape `(7,)`.
        present: Whether each count was read, shape `(7,)`.
    """
    state.nis = math.nan
    state.lost[:] = 0.0
    state.updated[:] = 0
    state.input_variance[:] = 0.0
    state.predicted = 0
    if not (present[0] and present[1] and present[2] and present[3]):
        return
    sense(settings, state, counts, present)
    if not state.placed:
        if state.linked:
            place(settings, state)
        return
    if not state.moved[0]:
        return
    state.predicted = 1
    predict_mean(settings, state)
    find_input_variance(settings, state)
    predict_covariance(settings, state)
    for wheel in range(4):
        state.alert[wheel] = max(0.0, state.alert[wheel] - abs(state.travel[wheel]))
    if state.linked:
        take(settings, state)


@compiled
def advance_filter(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Take one sample `(7,)` of a live stream, in place; `settings` and `states` are records `(1,)`."""
    advance(settings[0], states[0], counts, present)
