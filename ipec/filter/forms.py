"""Sensitivities of the readings and the travel of a step to a hypothesis' error; compiled.

The error's sizes are the states from `WANDER` on. A wheel with a delay tau has lost tau times the change of
its speed over a step. One that slips by c times its acceleration has lost c times half the change of its
squared speed. A truck that creeps on a slope moves by a fraction of its travel in one direction of the floor.
Two trucks that push each other because the slider sticks creep apart along the link: truck a by 1 + s, truck
b by 1 - s times the first size, where s is the second. A joint with play reads the middle of the gap minus
half its width on the side to which it last moved.
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
    LENGTH,
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
    """Fill the mean speeds of wheels and joints in the completed step."""
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
def lag_rate(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> float:
    """Return the effective rate of a joint with a late reading in a step [rad/s]: error = -delay x rate.

    For the part of the step that the delay covers, the rate is that of the previous step. The moment at which
    the rate changed is unknown; its uniform distribution is the added variance.
    """
    now, change = state.rate[opened.reading], state.rate[opened.reading] - state.rate_before[opened.reading]
    delay, time = opened.offset[WANDER], settings.period * max(state.samples, 1)
    most = (abs(delay) + math.sqrt(opened.covariance[WANDER, WANDER])) * change
    opened.form_variance = most * most / 12.0
    lagging: float = now - 0.5 * min(max(delay / time, 0.0), 2.0) * change
    return lagging


@compiled
def reading_sensitivities(
    settings: FilterSettings, state: FilterState, opened: OpenFilter
) -> tuple[float, float]:
    """Return the derivatives of a linkage reading by both sizes of the error, in the middle of a step."""
    number, form = opened.reading, opened.form
    if form == LINK_SCALE:
        return 0.5 * (state.step_start[3] + state.mean[LENGTH]) - settings.length, 0.0
    if form == LATE:
        return -lag_rate(settings, state, opened), 0.0
    if form == PLAY:
        return -opened.mean_play_position, 0.0
    if form == OFF_CENTRE:
        joint = number if number < 2 else 0
        angle = 0.5 * (state.mean[JOINT_A + joint] + state.step_start[1 + joint])
        return math.sin(angle), math.cos(angle)
    return 1.0, 0.0


@compiled
def fill_sensitivities(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
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
        first, second = reading_sensitivities(settings, state, opened)
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
