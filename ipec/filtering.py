"""One sample of the filter, compiled: predict, find disturbed wheels, update, and absolute fixes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ipec.disturbance import find_disturbed
from ipec.filter_records import (
    JOINT_A,
    JOINT_BIAS,
    LENGTH,
    LINK,
    POSE,
    STATES,
    FilterSettings,
    FilterState,
    X,
    Y,
)
from ipec.geometry import wrap
from ipec.measurement import update
from ipec.prediction import find_input_variance, predict_covariance, predict_mean
from ipec.readings import sense
from vehicle.compiled import Array, IntArray, Record, compiled

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
        own = settings.half[number] ** 2 / 3.0 + settings.blur[number] + covariance[bias, bias]
        covariance[true, true] = own
        covariance[true, bias] = covariance[bias, true] = -covariance[bias, bias]
    state.mean[LINK] -= state.mean[JOINT_A]
    covariance[LINK, LINK] += covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_A] = covariance[JOINT_A, LINK] = -covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_BIAS] = covariance[JOINT_BIAS, LINK] = covariance[JOINT_BIAS, JOINT_BIAS]
    state.placed = 1


@compiled
def take(settings: FilterSettings, state: FilterState) -> None:
    """Take the three readings of the linkage, and what they say of the distrusted wheels."""
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
    """Take one sample; the trucks move only where all four wheels were read."""
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
    """Take one sample `(7,)` of a live stream, in place."""
    advance(settings[0], states[0], counts, present)


@compiled
def look(mean: Array, covariance: Array, truck: int, pose: Array, sigma: Array) -> None:
    """Fill the pose `(3,)` and its standard deviations `(3,)` of a truck."""
    joint = JOINT_A + truck
    pose[0], pose[1], pose[2] = mean[X], mean[Y], mean[LINK] + mean[joint]
    cos = sin = 0.0  # by length of the link, for truck b
    if truck == 1:
        cos, sin = math.cos(mean[LINK]), math.sin(mean[LINK])
    ahead, aside = mean[LENGTH] * cos, mean[LENGTH] * sin
    pose[0] -= ahead
    pose[1] -= aside
    sigma[0] = spread_along(covariance, X, aside, -cos)
    sigma[1] = spread_along(covariance, Y, -ahead, -sin)
    own = covariance[LINK, LINK] + 2.0 * covariance[LINK, joint] + covariance[joint, joint]
    sigma[2] = math.sqrt(max(own, 0.0))


@compiled
def spread_along(covariance: Array, own: int, by_link: float, by_length: float) -> float:
    """Return the standard deviation of a coordinate, from its derivatives by the link."""
    total = covariance[own, own]
    total += 2.0 * (by_link * covariance[own, LINK] + by_length * covariance[own, LENGTH])
    total += by_link * (by_link * covariance[LINK, LINK] + 2.0 * by_length * covariance[LINK, LENGTH])
    return math.sqrt(max(total + by_length * by_length * covariance[LENGTH, LENGTH], 0.0))


@compiled
def fill_pose_rows(mean: Array, truck: int, rows: Array) -> None:
    """Fill the derivatives `(3, 15)` of a truck's pose by the states."""
    rows[:] = 0.0
    rows[0, X] = rows[1, Y] = rows[2, LINK] = rows[2, JOINT_A + truck] = 1.0
    if truck == 1:
        cos, sin = math.cos(mean[LINK]), math.sin(mean[LINK])
        rows[0, LENGTH], rows[0, LINK] = -cos, mean[LENGTH] * sin
        rows[1, LENGTH], rows[1, LINK] = -sin, -mean[LENGTH] * cos


@compiled
def fix_one(state: FilterState, truck: int, number: int, value: float, sigma: float, gain: Array) -> None:
    """Take one coordinate of an absolute pose; leave its gain `(17,)`, all zero where it is nan."""
    row, pose, own = np.empty((3, STATES)), np.empty(3), np.empty(3)
    look(state.mean, state.covariance, truck, pose, own)
    fill_pose_rows(state.mean, truck, row)
    offset = value - pose[number]
    gain[:] = 0.0
    if math.isnan(offset) or math.isnan(sigma):
        return
    if number == 2:
        offset = wrap(offset)
    for one in range(STATES):
        for other in range(STATES):
            gain[one] += state.covariance[one, other] * row[number, other]
    variance = sigma * sigma
    for one in range(STATES):
        variance += row[number, one] * gain[one]
    gain[STATES], gain[STATES + 1] = offset / variance, 1.0 / variance
    for one in range(STATES):
        state.mean[one] += gain[one] * offset / variance
        for other in range(STATES):
            state.covariance[one, other] -= gain[one] * gain[other] / variance


@compiled
def take_fix(states: Record, truck: int, fix: Array, sigma: Array) -> None:
    """Take an absolute pose `(3,)` of a truck with standard deviations `(3,)`, in place; nan is skipped."""
    gain = np.empty(STATES + 2)
    for number in range(3):
        fix_one(states[0], truck, number, fix[number], sigma[number], gain)
