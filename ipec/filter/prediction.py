"""Prediction: two trucks that roll and creep sideways a little, seen from their link; how errors grow.

The derivatives are by the link's heading and length and the joints, not by a pose as in `vehicle.arcs`.
"""

import math

import numpy as np

from omnimate.ipec.filter.hypotheses import ENCODERS, TRUCKS
from omnimate.ipec.filter.records import (
    CREEP,
    INPUTS,
    JOINT_A,
    JOINT_BIAS,
    LENGTH,
    LINK,
    POSE,
    STATES,
    WANDER,
    WHEEL,
    WHEELBASE,
    FilterSettings,
    FilterState,
    OpenFilter,
    X,
    Y,
)
from omnimate.vehicle.arcs import sinc_of
from omnimate.vehicle.compiled import Array, compiled


@compiled
def rolled(
    settings: FilterSettings, state: FilterState, truck: int, travel: Array
) -> tuple[float, float, float]:
    """Return a truck's chord [m], turn [rad] and wheelbase [m] for the travel of the wheels `(4,)`."""
    left, right = 2 * truck, 2 * truck + 1
    travel_left = travel[left] * (1.0 + state.mean[WHEEL + left])
    travel_right = travel[right] * (1.0 + state.mean[WHEEL + right])
    wheelbase = settings.wheelbase[truck] * (1.0 + state.mean[WHEELBASE + truck])
    turn = (travel_right - travel_left) / wheelbase
    return 0.5 * (travel_left + travel_right) * sinc_of(0.5 * turn), turn, wheelbase


@compiled
def predict_mean(settings: FilterSettings, state: FilterState) -> None:
    """Move the mean by one sample's travel."""
    mean = state.mean
    along, aside = mean[LENGTH], 0.0
    turns = np.empty(2)
    for truck in range(2):
        chord, turn, _ = rolled(settings, state, truck, state.travel)
        creep = -mean[CREEP + truck] * chord * turn / settings.period
        side, course = 1.0 - 2.0 * truck, mean[JOINT_A + truck] + 0.5 * turn
        along += side * (chord * math.cos(course) - creep * math.sin(course))
        aside += side * (chord * math.sin(course) + creep * math.cos(course))
        turns[truck] = turn
        if truck == 0:
            heading = mean[LINK] + course
            mean[X] += chord * math.cos(heading) - creep * math.sin(heading)
            mean[Y] += chord * math.sin(heading) + creep * math.cos(heading)
    swing = math.atan2(aside, along)
    mean[LINK] += swing
    for truck in range(2):
        mean[JOINT_A + truck] += turns[truck] - swing
    mean[LENGTH] = math.hypot(along, aside)


@compiled
def differentiate(settings: FilterSettings, state: FilterState) -> None:
    """Fill the derivatives of the step that ends here, from the travel since its start."""
    state.transition[:] = 0.0
    state.inputs[:] = 0.0
    swing = state.mean[LINK] - state.begun[0]
    for truck in range(2):
        _differentiate(settings, state, truck, swing)
    transition, length = state.transition, state.mean[LENGTH]
    transition[X, X] = transition[Y, Y] = transition[LINK, LINK] = 1.0
    transition[LENGTH, LENGTH] = math.cos(swing)
    transition[LINK, LENGTH] = -math.sin(swing) / length
    for joint in range(2):
        transition[JOINT_A + joint, LENGTH] = math.sin(swing) / length


@compiled
def _differentiate(settings: FilterSettings, state: FilterState, truck: int, swing: float) -> None:
    """Fill what depends on one truck: by its joint, its wheels, its wheelbase and its sideways slip."""
    side, length = 1.0 - 2.0 * truck, state.mean[LENGTH]
    chord, turn, wheelbase = rolled(settings, state, truck, state.way)
    course = state.begun[1 + truck] + 0.5 * turn
    cos, sin = side * math.cos(course - swing), side * math.sin(course - swing)
    ahead = np.zeros(POSE)  # by a way along the course
    beside = np.zeros(POSE)  # by a way to the left of it
    turned = np.zeros(POSE)  # by a turn, half of which changes the course
    ahead[LENGTH], ahead[LINK] = cos, sin / length
    beside[LENGTH], beside[LINK] = -sin, cos / length
    if truck == 0:
        heading = state.begun[0] + course
        ahead[X], ahead[Y] = math.cos(heading), math.sin(heading)
        beside[X], beside[Y] = -math.sin(heading), math.cos(heading)
    for joint in range(2):
        ahead[JOINT_A + joint] = -ahead[LINK]
        beside[JOINT_A + joint] = -beside[LINK]
    turned[JOINT_A + truck] = 1.0
    slip = -chord * turn / (settings.period * state.samples)
    for row in range(POSE):
        turned[row] += 0.5 * chord * beside[row]
        state.transition[row, JOINT_A + truck] = chord * beside[row]
        state.transition[row, WHEELBASE + truck] = -turn * turned[row]
        state.transition[row, CREEP + truck] = slip * beside[row]
        state.inputs[row, 4 + truck] = beside[row]
        state.inputs[row, 6 + truck] = ahead[row]
        for right in range(2):
            wheel = 2 * truck + right
            by_travel = 0.5 * ahead[row] + (2.0 * right - 1.0) / wheelbase * turned[row]
            state.inputs[row, wheel] = by_travel
            state.transition[row, WHEEL + wheel] = state.way[wheel] * by_travel
    state.transition[JOINT_A + truck, JOINT_A + truck] += 1.0
    if truck == 0:
        state.transition[X, LINK] = chord * beside[X]
        state.transition[Y, LINK] = chord * beside[Y]


@compiled
def level_of(number: int) -> int:
    """Return the level of noise of an input: 0 and 1 of the wheels of a and b, 2 sideways, 3 ahead."""
    return number // 2


@compiled
def find_input_variance(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Fill the variance of the inputs of the step.

    It grows with the travel, Chong & Kleeman (1997); that of a distrusted input with what was rolled.

    Args:
        settings: Settings of the filter.
        state: Estimate with the levels of noise.
        opened: Open filter; its `input_variance` is filled.
    """
    way, out = 0.25 * state.rolled.sum(), opened.input_variance
    for number in range(INPUTS):
        by = state.rolled[number] if number < 4 else way
        out[number] = state.levels[level_of(number)] * by
        if number < 4 and by > 0.0:
            out[number] += settings.resolution[number]
        if opened.alert[number] > 0.0:
            out[number] += (settings.distrust * by) ** 2


@compiled
def predict_covariance(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Propagate offset and covariance: F P F' + G Q G' and the drift of the slow factors, in place."""
    covariance, transition, carried = opened.covariance, state.transition, state.carried
    carry(transition, covariance, carried)
    for row in range(POSE):
        for column in range(row + 1):
            total = 0.0
            for middle in range(JOINT_BIAS):
                total += carried[row, middle] * transition[column, middle]
            covariance[row, column] = covariance[column, row] = total
        for column in range(POSE, STATES):
            covariance[row, column] = covariance[column, row] = carried[row, column]
    for number in range(INPUTS):
        add_input(state, opened, number, opened.input_variance[number])
    way = 0.25 * state.rolled.sum()
    for number in range(WHEEL, CREEP):
        covariance[number, number] += settings.drift * way
    offset, moved = opened.offset, carried[0]
    for row in range(POSE):
        moved[row] = 0.0
        for middle in range(JOINT_BIAS):
            moved[row] += transition[row, middle] * offset[middle]
    for row in range(POSE):
        offset[row] = moved[row]


@compiled
def carry(transition: Array, covariance: Array, out: Array) -> None:
    """Fill F P `(6, 19)`; the biases, which come last, move nothing."""
    out[:] = 0.0
    for row in range(POSE):
        for middle in range(JOINT_BIAS):
            factor = transition[row, middle]
            if factor != 0.0:
                for column in range(STATES):
                    out[row, column] += factor * covariance[middle, column]


@compiled
def add_input(state: FilterState, opened: OpenFilter, number: int, variance: float) -> None:
    """Add the effect of an input's variance [m^2] on the covariance of the first six states."""
    covariance = opened.covariance
    if variance == 0.0:
        return
    for row in range(POSE):
        factor = variance * state.inputs[row, number]
        for column in range(POSE):
            covariance[row, column] += factor * state.inputs[column, number]


@compiled
def wander(state: FilterState, opened: OpenFilter) -> None:
    """Let fade what wanders under a hypothesis, and wander anew, in place.

    A heading by wheels that comes back takes the truck's joint with it.
    """
    way = 0.25 * state.rolled.sum()
    lasting = opened.lasting = math.exp(-way / opened.alike)
    covariance, offset, row = opened.covariance, opened.offset, WANDER
    variance = (1.0 - lasting * lasting) * opened.variance[0]
    if variance == 0.0:
        return
    joint = returns_to(opened.reading)
    if joint >= 0:
        offset[joint] += (1.0 - lasting) * offset[row]
        for column in range(STATES):
            covariance[joint, column] += (1.0 - lasting) * covariance[row, column]
        for column in range(STATES):
            covariance[column, joint] += (1.0 - lasting) * covariance[column, row]
    offset[row] *= lasting
    for column in range(STATES):
        covariance[row, column] *= lasting
        covariance[column, row] *= lasting
    covariance[row, row] += variance
    if joint >= 0:
        covariance[joint, joint] += variance
        covariance[row, joint] -= variance
        covariance[joint, row] -= variance


@compiled
def returns_to(reading: int) -> int:
    """Return the state that takes what comes back of one of `hypotheses.READINGS`; -1 for none."""
    return JOINT_A + reading - TRUCKS if TRUCKS <= reading < ENCODERS else -1
