"""How an error of a known form enters the readings and the travel of a step; compiled.

Its sizes are the states from `WANDER` on. They enter a reading of the linkage with a share, and the travel
of a wheel, or of a truck, with what a unit of them adds to the step. A wheel whose reading is late by tau
has read tau times its speed too little: over a step that is tau times the change of its speed. One that
slips by c times its acceleration has lost c times the change of half its squared speed. A truck that creeps
on a slope goes by a part of its way towards one direction of the floor, ahead and to the side. Two
trucks that push each other, because the slider sticks, creep along the link and away from each other: truck a
by 1 + s, and truck b by 1 - s of the first size, where s is the second. A joint with play reads the middle of
it less the half that its last motion has taken up, to the side to which it has moved.
"""

import math

from omnimate.ipec.filter.hypotheses import (
    ENCODERS,
    LATE,
    OFF_CENTRE,
    PLAY,
    PUSH,
    SLOPE,
    STRETCH,
    TRUCKS,
    WANDERS,
    ZEROED,
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
def follow_motion(settings: FilterSettings, state: FilterState) -> None:
    """Fill the mean speeds of wheels and joints in the step that ends here."""
    for wheel in range(4):
        state.speed_before[wheel] = state.speed[wheel]
        state.speed[wheel] = state.way[wheel] / (settings.period * state.samples)
    for joint in range(2):
        state.rate_before[joint] = state.rate[joint]
        moved = state.mean[JOINT_A + joint] - state.begun[1 + joint]
        state.rate[joint] = moved / (settings.period * state.samples)


@compiled
def take_up(state: FilterState, opened: OpenFilter) -> None:
    """Move a joint within its play, whose half is at most its size and a standard deviation of it.

    Until the joint has gone through the play, its reading may err by anything up to that half.
    """
    moved = state.mean[JOINT_A + opened.reading] - state.begun[1 + opened.reading]
    half = abs(opened.offset[WANDER]) + math.sqrt(opened.covariance[WANDER, WANDER])
    before = opened.touched
    if half > 0.0:
        opened.touched = min(max(before + moved / half, -1.0), 1.0)
    opened.side = 0.5 * (before + opened.touched)
    opened.vague = half * half * (1.0 - opened.side * opened.side)


@compiled
def lag(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> float:
    """Return the rate of a joint at which its late reading lags behind in a step [rad/s].

    A reading that is late by a part of the step's time has turned for that part at the rate of the step
    before. Where in the two steps the rate has changed is not known.
    """
    now, change = state.rate[opened.reading], state.rate[opened.reading] - state.rate_before[opened.reading]
    delay, time = opened.offset[WANDER], settings.period * max(state.samples, 1)
    most = (abs(delay) + math.sqrt(opened.covariance[WANDER, WANDER])) * change
    opened.vague = most * most / 12.0
    lagging: float = now - 0.5 * min(max(delay / time, 0.0), 2.0) * change
    return lagging


@compiled
def share_in_reading(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> tuple[float, float]:
    """Return by what a reading of the linkage changes per unit of each size, in the middle of a step."""
    number, form = opened.reading, opened.form
    if form == STRETCH:
        return 0.5 * (state.begun[3] + state.mean[LENGTH]) - settings.length, 0.0
    if form == LATE:
        return -lag(settings, state, opened), 0.0
    if form == PLAY:
        return -opened.side, 0.0
    if form in (OFF_CENTRE, ZEROED):
        joint = number if number < 2 else 0
        angle = 0.5 * (state.mean[JOINT_A + joint] + state.begun[1 + joint])
        return math.sin(angle), math.cos(angle) - (1.0 if form == ZEROED else 0.0)
    return 1.0, 0.0


@compiled
def shape_error(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Fill how what errs under a hypothesis enters the readings and the motion of the step that ends here."""
    opened.share[:] = 0.0
    opened.gained[:] = 0.0
    if opened.form == PUSH:
        way, creep = 0.25 * state.rolled.sum(), opened.offset[WANDER]
        for truck in range(2):
            angle = 0.5 * (state.begun[1 + truck] + state.mean[JOINT_A + truck])
            aside, ahead, away = -way * math.sin(angle), way * math.cos(angle), 1.0 - 2.0 * truck
            opened.gained[SIDES + truck, 0], opened.gained[SIDES + truck, 1] = away * aside, creep * aside
            opened.gained[AHEAD + truck, 0], opened.gained[AHEAD + truck, 1] = away * ahead, creep * ahead
    elif 0 <= opened.reading < TRUCKS:
        if opened.form == PLAY:
            take_up(state, opened)
        first, second = share_in_reading(settings, state, opened)
        opened.share[0, opened.reading], opened.share[1, opened.reading] = first, second
    elif opened.form == WANDERS and opened.reading >= ENCODERS:
        wheel = opened.reading - ENCODERS
        opened.gained[wheel, 0] = state.way[wheel]
    elif opened.form == LATE:
        first, last = wheels_of(opened.reading)
        for wheel in range(first, last):
            now, before = state.speed[wheel], state.speed_before[wheel]
            opened.gained[wheel, 0] = now - before
            opened.gained[wheel, 1] = 0.5 * (before * abs(before) - now * abs(now))
    elif opened.form == SLOPE:
        truck = opened.reading - TRUCKS
        begun, joint = state.begun, JOINT_A + truck
        heading = 0.5 * (begun[0] + begun[1 + truck] + state.mean[LINK] + state.mean[joint])
        way = 0.5 * abs(state.way[2 * truck] + state.way[2 * truck + 1])
        cos, sin = way * math.cos(heading), way * math.sin(heading)
        opened.gained[SIDES + truck, 0], opened.gained[SIDES + truck, 1] = -sin, cos
        opened.gained[AHEAD + truck, 0], opened.gained[AHEAD + truck, 1] = cos, sin
    move_by_error(state.inputs, opened, state.transition)


@compiled
def wheels_of(reading: int) -> tuple[int, int]:
    """Return the first wheel that a reading of wheels stands for, and that after the last."""
    if reading >= ENCODERS:
        return reading - ENCODERS, reading - ENCODERS + 1
    return 2 * (reading - TRUCKS), 2 * (reading - TRUCKS) + 2


@compiled
def move_by_error(inputs: Array, opened: OpenFilter, transition: Array) -> None:
    """Fill the derivative of the first six states by what errs, in a transition `(6, 19)`."""
    for row in range(POSE):
        for error in range(ERRORS):
            transition[row, WANDER + error] = 0.0
    for number in range(INPUTS):
        for error in range(ERRORS):
            gained = opened.gained[number, error]
            if gained != 0.0:
                for row in range(POSE):
                    transition[row, WANDER + error] += gained * inputs[row, number]
