"""Sensitivities of the readings and the travel of a step to a hypothesis' error; compiled.

The error's sizes are the states from `WANDER` on. A wheel with a delay tau has lost tau times the change of
its speed over a step. One that slips by c times its acceleration has lost c times half the change of its
squared speed. A truck that creeps on a slope moves by a fraction of its travel in one direction of the floor.
Two trucks that push each other because the slider sticks creep apart along the link: truck a by 1 + s, truck
b by 1 - s times the first size, where s is the second. A joint with play reads the middle of the gap minus
half its width on the side to which it last moved.

Truck b is steered by the joint and the link that it is known by: a bump is answered at once, and what the
floor does goes on for 0.2 m (`prior.FilterNoise.correlated`). Errors of these readings are therefore held
against what the linkage did before (closed-loop identification: Forssell and Ljung, Automatica 1999).
"""

import math

from omnimate.ipec.filter.hypotheses import (
    ENCODERS,
    LATE,
    LINK_SCALE,
    OFF_CENTRE,
    PLAY,
    PUSH,
    SLOPE,
    TRUCKS,
    WANDERS,
)
from omnimate.ipec.filter.records import (
    AHEAD,
    ERRORS,
    INPUTS,
    JOINT_A,
    LINK,
    POSE,
    SIDES,
    WANDER,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled


@compiled
def fill_speeds(settings: FilterSettings, state: FilterState) -> None:
    """Fill the mean speeds of wheels and joints in the completed step, and the link's extensions."""
    state.extensions[:-1] = state.extensions[1:]
    state.extensions[-1] = state.step_start[3] - settings.length
    for wheel in range(4):
        state.speed_before[wheel] = state.speed[wheel]
        state.speed[wheel] = state.step_travel[wheel] / (settings.period * state.samples)
    for joint in range(2):
        state.rate_before[joint] = state.rate[joint]
        moved = state.mean[JOINT_A + joint] - state.step_start[1 + joint]
        state.rate[joint] = moved / (settings.period * state.samples)


@compiled
def update_play(state: FilterState, opened: OpenFilter) -> None:
    """Update the position of a joint within its play.

    The half-width is taken as its estimate plus one standard deviation. Until the joint has crossed the play,
    its reading may be wrong by up to that.
    """
    moved = state.mean[JOINT_A + opened.reading] - state.step_start[1 + opened.reading]
    half = abs(opened.offset[WANDER]) + math.sqrt(opened.covariance[WANDER, WANDER])
    before = opened.play_position
    if half > 0.0:
        opened.play_position = min(max(before + moved / half, -1.0), 1.0)
    opened.mean_play_position = 0.5 * (before + opened.play_position)
    opened.form_variance = half * half * (1.0 - opened.mean_play_position * opened.mean_play_position)


@compiled
def lag_rate(state: FilterState, opened: OpenFilter) -> float:
    """Return the rate of a joint with a late reading [rad/s]: error = -delay x rate.

    It is that of the step before. The rate has changed at an unknown moment since; its uniform distribution
    is the added variance.
    """
    change = state.rate[opened.reading] - state.rate_before[opened.reading]
    most = (abs(opened.offset[WANDER]) + math.sqrt(opened.covariance[WANDER, WANDER])) * change
    opened.form_variance = most * most / 3.0
    before: float = state.rate_before[opened.reading]
    return before


@compiled
def reading_sensitivities(state: FilterState, opened: OpenFilter) -> tuple[float, float]:
    """Return the derivatives of a linkage reading by both sizes of the error in a step."""
    number, form = opened.reading, opened.form
    if form == LINK_SCALE:
        return state.extensions[0], 0.0
    if form == LATE:
        return -lag_rate(state, opened), 0.0
    if form == PLAY:
        return -opened.mean_play_position, 0.0
    if form == OFF_CENTRE:
        joint = number if number < 2 else 0
        angle = 0.5 * (state.mean[JOINT_A + joint] + state.step_start[1 + joint])
        return math.sin(angle), math.cos(angle)
    return 1.0, 0.0


@compiled
def fill_sensitivities(state: FilterState, opened: OpenFilter) -> None:
    """Fill the derivatives of readings and motion of the completed step by the error's sizes."""
    by_input, by_reading = opened.input_sensitivity, opened.reading_sensitivity
    by_reading[:] = 0.0
    by_input[:] = 0.0
    if opened.form == PUSH:
        distance, creep = 0.25 * state.step_distance.sum(), opened.offset[WANDER]
        for truck in range(2):
            angle = 0.5 * (state.step_start[1 + truck] + state.mean[JOINT_A + truck])
            aside, ahead, away = -distance * math.sin(angle), distance * math.cos(angle), 1.0 - 2.0 * truck
            by_input[SIDES + truck, 0], by_input[SIDES + truck, 1] = away * aside, creep * aside
            by_input[AHEAD + truck, 0], by_input[AHEAD + truck, 1] = away * ahead, creep * ahead
    elif 0 <= opened.reading < TRUCKS:
        if opened.form == PLAY:
            update_play(state, opened)
        first, second = reading_sensitivities(state, opened)
        by_reading[0, opened.reading], by_reading[1, opened.reading] = first, second
    elif opened.form == WANDERS and opened.reading >= ENCODERS:
        wheel = opened.reading - ENCODERS
        by_input[wheel, 0] = state.step_travel[wheel]
    elif opened.form == LATE:
        first, last = wheel_range(opened.reading)
        for wheel in range(first, last):
            now, before = state.speed[wheel], state.speed_before[wheel]
            by_input[wheel, 0] = now - before
            by_input[wheel, 1] = 0.5 * (before * abs(before) - now * abs(now))
    elif opened.form == SLOPE:
        truck = opened.reading - TRUCKS
        begun, joint = state.step_start, JOINT_A + truck
        heading = 0.5 * (begun[0] + begun[1 + truck] + state.mean[LINK] + state.mean[joint])
        distance = 0.5 * abs(state.step_travel[2 * truck] + state.step_travel[2 * truck + 1])
        cos, sin = distance * math.cos(heading), distance * math.sin(heading)
        by_input[SIDES + truck, 0], by_input[SIDES + truck, 1] = -sin, cos
        by_input[AHEAD + truck, 0], by_input[AHEAD + truck, 1] = cos, sin
    fill_error_transition(state.inputs, opened, state.transition)


@compiled
def wheel_range(reading: int) -> tuple[int, int]:
    """Return the range of wheels that a wheel reading refers to: the first, and one past the last."""
    if reading >= ENCODERS:
        return reading - ENCODERS, reading - ENCODERS + 1
    return 2 * (reading - TRUCKS), 2 * (reading - TRUCKS) + 2


@compiled
def fill_error_transition(inputs: Array, opened: OpenFilter, transition: Array) -> None:
    """Fill the derivatives of the first six states by the error's sizes in a transition `(6, 19)`."""
    for row in range(POSE):
        for error in range(ERRORS):
            transition[row, WANDER + error] = 0.0
    for number in range(INPUTS):
        for error in range(ERRORS):
            gained = opened.input_sensitivity[number, error]
            if gained != 0.0:
                for row in range(POSE):
                    transition[row, WANDER + error] += gained * inputs[row, number]
