"""Prediction of mean and covariance: two trucks that roll and creep sideways, in the frame of their link.

The derivatives are by heading and length of the link and the joints, not by a pose as in `vehicle.arcs`.
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
def truck_arc(
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
    """Advance the mean by one sample's travel."""
    mean = state.mean
    along, aside = mean[LENGTH], 0.0
    turns = np.empty(2)
    for truck in range(2):
        chord, turn, _ = truck_arc(settings, state, truck, state.travel)
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
    swing = state.mean[LINK] - state.step_start[0]
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
    chord, turn, wheelbase = truck_arc(settings, state, truck, state.step_travel)
    course = state.step_start[1 + truck] + 0.5 * turn
    cos, sin = side * math.cos(course - swing), side * math.sin(course - swing)
    ahead = np.zeros(POSE)  # derivative by travel along the course
    leftward = np.zeros(POSE)  # derivative by travel to the left of it
    turned = np.zeros(POSE)  # derivative by a turn, half of which changes the course
    ahead[LENGTH], ahead[LINK] = cos, sin / length
    leftward[LENGTH], leftward[LINK] = -sin, cos / length
    if truck == 0:
        heading = state.step_start[0] + course
        ahead[X], ahead[Y] = math.cos(heading), math.sin(heading)
        leftward[X], leftward[Y] = -math.sin(heading), math.cos(heading)
    for joint in range(2):
        ahead[JOINT_A + joint] = -ahead[LINK]
        leftward[JOINT_A + joint] = -leftward[LINK]
    turned[JOINT_A + truck] = 1.0
    slip = -chord * turn / (settings.period * state.samples)
    for row in range(POSE):
        turned[row] += 0.5 * chord * leftward[row]
        state.transition[row, JOINT_A + truck] = chord * leftward[row]
        state.transition[row, WHEELBASE + truck] = -turn * turned[row]
        state.transition[row, CREEP + truck] = slip * leftward[row]
        state.inputs[row, 4 + truck] = leftward[row]
        state.inputs[row, 6 + truck] = ahead[row]
        for right in range(2):
            wheel = 2 * truck + right
            by_travel = 0.5 * ahead[row] + (2.0 * right - 1.0) / wheelbase * turned[row]
            state.inputs[row, wheel] = by_travel
            state.transition[row, WHEEL + wheel] = state.step_travel[wheel] * by_travel
    state.transition[JOINT_A + truck, JOINT_A + truck] += 1.0
    if truck == 0:
        state.transition[X, LINK] = chord * leftward[X]
        state.transition[Y, LINK] = chord * leftward[Y]


@compiled
def noise_level_of(number: int) -> int:
    """Return the number of an input's noise level: 0, 1 wheels of a, b; 2 sideways slip; 3 slip ahead."""
    return number // 2


@compiled
def fill_input_variance(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Fill the variance of the inputs of the step, given the levels of noise.

    It is proportional to the travel, Chong & Kleeman (1997); of a distrusted input, to its square.
    """
    distance, out = 0.25 * state.step_distance.sum(), opened.input_variance
    for number in range(INPUTS):
        by = state.step_distance[number] if number < 4 else distance
        out[number] = state.levels[noise_level_of(number)] * by
        if number < 4 and by > 0.0:
            out[number] += settings.resolution[number]
        if opened.alert[number] > 0.0:
            out[number] += (settings.distrust * by) ** 2


@compiled
def predict_covariance(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Propagate offset and covariance: F P F' + G Q G' and the drift of the slow factors, in place."""
    covariance, transition, carried = opened.covariance, state.transition, state.carried
    multiply_transition(transition, covariance, carried)
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
    distance = 0.25 * state.step_distance.sum()
    for number in range(WHEEL, CREEP):
        covariance[number, number] += settings.drift * distance
    offset, moved = opened.offset, carried[0]
    for row in range(POSE):
        moved[row] = 0.0
        for middle in range(JOINT_BIAS):
            moved[row] += transition[row, middle] * offset[middle]
    for row in range(POSE):
        offset[row] = moved[row]


@compiled
def multiply_transition(transition: Array, covariance: Array, out: Array) -> None:
    """Fill F P `(6, 19)`; the biases, the last states, do not act on the motion."""
    out[:] = 0.0
    for row in range(POSE):
        for middle in range(JOINT_BIAS):
            factor = transition[row, middle]
            if factor != 0.0:
                for column in range(STATES):
                    out[row, column] += factor * covariance[middle, column]


@compiled
def add_input(state: FilterState, opened: OpenFilter, number: int, variance: float) -> None:
    """Add an input's variance [m^2] to the covariance of the first six states."""
    covariance = opened.covariance
    if variance == 0.0:
        return
    for row in range(POSE):
        factor = variance * state.inputs[row, number]
        for column in range(POSE):
            covariance[row, column] += factor * state.inputs[column, number]


@compiled
def decay_error(state: FilterState, opened: OpenFilter) -> None:
    """Propagate the Gauss-Markov error of a hypothesis over a step, in place.

    If it is an error of a heading by wheels, its decay also turns the truck's joint.
    """
    distance = 0.25 * state.step_distance.sum()
    decay = opened.decay = math.exp(-distance / opened.correlation_length)
    covariance, offset, row = opened.covariance, opened.offset, WANDER
    variance = (1.0 - decay * decay) * opened.variance[0]
    if variance == 0.0:
        return
    joint = restored_joint(opened.reading)
    if joint >= 0:
        offset[joint] += (1.0 - decay) * offset[row]
        for column in range(STATES):
            covariance[joint, column] += (1.0 - decay) * covariance[row, column]
        for column in range(STATES):
            covariance[column, joint] += (1.0 - decay) * covariance[column, row]
    offset[row] *= decay
    for column in range(STATES):
        covariance[row, column] *= decay
        covariance[column, row] *= decay
    covariance[row, row] += variance
    if joint >= 0:
        covariance[joint, joint] += variance
        covariance[row, joint] -= variance
        covariance[joint, row] -= variance


@compiled
def restored_joint(reading: int) -> int:
    """Return the joint state that a decaying heading error of `hypotheses.READINGS` changes; -1 for none."""
    return JOINT_A + reading - TRUCKS if TRUCKS <= reading < ENCODERS else -1
