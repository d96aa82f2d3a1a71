"""Prediction: two trucks that roll without sideways slip, seen from their link, and how errors grow."""

import math

import numpy as np

from omnimate.ipec.filter.records import (
    INPUTS,
    JOINT_A,
    JOINT_BIAS,
    LENGTH,
    LINK,
    POSE,
    STATES,
    WHEEL,
    WHEELBASE,
    FilterSettings,
    FilterState,
    X,
    Y,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.compiled_se2 import sinc


@compiled
def rolled(settings: FilterSettings, state: FilterState, truck: int) -> tuple[float, float, float, float]:
    """Return a truck's chord [m], turn [rad], course against the link [rad] and wheelbase [m]."""
    left, right = 2 * truck, 2 * truck + 1
    travel_left = state.travel[left] * (1.0 + state.mean[WHEEL + left])
    travel_right = state.travel[right] * (1.0 + state.mean[WHEEL + right])
    wheelbase = settings.wheelbase[truck] * (1.0 + state.mean[WHEELBASE + truck])
    turn = (travel_right - travel_left) / wheelbase
    half = 0.5 * turn
    chord = 0.5 * (travel_left + travel_right) * sinc(half)
    return chord, turn, state.mean[JOINT_A + truck] + half, wheelbase


@compiled
def predict_mean(settings: FilterSettings, state: FilterState) -> None:
    """Move the mean by one sample's travel, and keep the derivatives of that step in the state."""
    mean = state.mean
    state.transition[:] = 0.0
    state.inputs[:] = 0.0
    chord_a, turn_a, course_a, base_a = rolled(settings, state, 0)
    chord_b, turn_b, course_b, base_b = rolled(settings, state, 1)
    along = mean[LENGTH] + chord_a * math.cos(course_a) - chord_b * math.cos(course_b)
    aside = chord_a * math.sin(course_a) - chord_b * math.sin(course_b)
    swing, length = math.atan2(aside, along), math.hypot(along, aside)
    _differentiate(state, 0, chord_a, turn_a, course_a, base_a, swing, length)
    _differentiate(state, 1, chord_b, turn_b, course_b, base_b, swing, length)
    _differentiate_link(state, swing, length)
    mean[X] += chord_a * math.cos(mean[LINK] + course_a)
    mean[Y] += chord_a * math.sin(mean[LINK] + course_a)
    mean[LINK] += swing
    mean[JOINT_A] += turn_a - swing
    mean[JOINT_A + 1] += turn_b - swing
    mean[LENGTH] = length


@compiled
def _differentiate(
    state: FilterState,
    truck: int,
    chord: float,
    turn: float,
    course: float,
    wheelbase: float,
    swing: float,
    length: float,
) -> None:
    """Fill what depends on one truck: by its joint, its wheels, its wheelbase and its sideways slip."""
    side = 1.0 - 2.0 * truck
    cos, sin = side * math.cos(course - swing), side * math.sin(course - swing)
    ahead = np.zeros(POSE)  # by a way along the course
    beside = np.zeros(POSE)  # by a way to the left of it
    turned = np.zeros(POSE)  # by a turn, half of which changes the course
    ahead[LENGTH], ahead[LINK] = cos, sin / length
    beside[LENGTH], beside[LINK] = -sin, cos / length
    if truck == 0:
        heading = state.mean[LINK] + course
        ahead[X], ahead[Y] = math.cos(heading), math.sin(heading)
        beside[X], beside[Y] = -math.sin(heading), math.cos(heading)
    for joint in range(2):
        ahead[JOINT_A + joint] = -ahead[LINK]
        beside[JOINT_A + joint] = -beside[LINK]
    turned[JOINT_A + truck] = 1.0
    for row in range(POSE):
        turned[row] += 0.5 * chord * beside[row]
        state.transition[row, JOINT_A + truck] = chord * beside[row]
        state.transition[row, WHEELBASE + truck] = -turn * turned[row]
        state.inputs[row, 4 + truck] = beside[row]
        for right in range(2):
            wheel = 2 * truck + right
            by_travel = 0.5 * ahead[row] + (2.0 * right - 1.0) / wheelbase * turned[row]
            state.inputs[row, wheel] = by_travel
            state.transition[row, WHEEL + wheel] = state.travel[wheel] * by_travel
    state.transition[JOINT_A + truck, JOINT_A + truck] += 1.0
    if truck == 0:
        state.transition[X, LINK] = chord * beside[X]
        state.transition[Y, LINK] = chord * beside[Y]


@compiled
def _differentiate_link(state: FilterState, swing: float, length: float) -> None:
    """Fill what depends on place, heading and length of the link."""
    state.transition[X, X] = 1.0
    state.transition[Y, Y] = 1.0
    state.transition[LINK, LINK] = 1.0
    state.transition[LENGTH, LENGTH] = math.cos(swing)
    state.transition[LINK, LENGTH] = -math.sin(swing) / length
    for joint in range(2):
        state.transition[JOINT_A + joint, LENGTH] = math.sin(swing) / length


@compiled
def find_input_variance(settings: FilterSettings, state: FilterState) -> None:
    """Fill the variance of the inputs.

    It grows with the travel, Chong & Kleeman (1997); that of a distrusted wheel with what it rolled.
    """
    for wheel in range(4):
        way = abs(state.travel[wheel])
        state.input_variance[wheel] = settings.roughness * way
        if way > 0.0:
            state.input_variance[wheel] += settings.resolution[wheel]
        if state.alert[wheel] > 0.0:
            state.input_variance[wheel] += (settings.distrust * way) ** 2
    for truck in range(2):
        way = 0.5 * abs(state.travel[2 * truck] + state.travel[2 * truck + 1])
        state.input_variance[4 + truck] = settings.sideways * way


@compiled
def predict_covariance(settings: FilterSettings, state: FilterState) -> None:
    """Propagate the covariance: F P F' + G Q G' and the drift of the slow factors, in place."""
    covariance, transition = state.covariance, state.transition
    carried = carry(state)
    for row in range(POSE):
        for column in range(row + 1):
            total = 0.0
            for middle in range(JOINT_BIAS):
                total += carried[row, middle] * transition[column, middle]
            covariance[row, column] = covariance[column, row] = total
        for column in range(POSE, STATES):
            covariance[row, column] = covariance[column, row] = carried[row, column]
    for number in range(INPUTS):
        add_input(state, number, state.input_variance[number])
    way = 0.25 * np.abs(state.travel).sum()
    for number in range(WHEEL, JOINT_BIAS):
        covariance[number, number] += settings.drift * way


@compiled
def carry(state: FilterState) -> Array:
    """Return F P `(6, 15)`; the biases, which come last, move nothing."""
    covariance, transition = state.covariance, state.transition
    out = np.zeros((POSE, STATES))
    for row in range(POSE):
        for middle in range(JOINT_BIAS):
            factor = transition[row, middle]
            if factor != 0.0:
                for column in range(STATES):
                    out[row, column] += factor * covariance[middle, column]
    return out


@compiled
def add_input(state: FilterState, number: int, variance: float) -> None:
    """Add the effect of an input's variance [m^2] on the covariance of the first six states."""
    if variance == 0.0:
        return
    for row in range(POSE):
        factor = variance * state.inputs[row, number]
        for column in range(POSE):
            state.covariance[row, column] += factor * state.inputs[column, number]
