"""Wheels that cross obstacles: when a crossing begins, and what travel it costs in each step."""

import math

from vcan_sim.records import Constants, Obstacle, State
from vehicle.compiled import compiled


@compiled
def touches(obstacle: Obstacle, constants: Constants, state: State) -> bool:
    """Return whether a wheel stands where an obstacle begins."""
    if obstacle.scheduled:
        if obstacle.lap >= 0:
            return bool(obstacle.lap == state.lap and state.rolled[1, obstacle.wheel] >= obstacle.after)
        return bool(state.rolled[0, obstacle.wheel] >= obstacle.after)
    truck, right = obstacle.wheel // 2, obstacle.wheel % 2
    arm = constants.wheelbase[truck] * (0.5 - right)
    heading = state.pose[truck, 2]
    x = state.pose[truck, 0] - arm * math.sin(heading)
    y = state.pose[truck, 1] + arm * math.cos(heading)
    return math.hypot(x - obstacle.x, y - obstacle.y) <= obstacle.size


@compiled
def lose_travel(obstacle: Obstacle, constants: Constants, state: State) -> None:
    """Take what one obstacle costs in this step off its wheel's travel, spread over the crossing."""
    touching = touches(obstacle, constants, state)
    if touching and not obstacle.met:
        obstacle.met = 1
        obstacle.remaining = obstacle.span
    elif obstacle.met and not touching and not obstacle.scheduled:
        obstacle.met = 0
    if obstacle.remaining <= 0.0:
        return
    rolled = constants.radius[obstacle.wheel] * state.turned[obstacle.wheel]
    part = min(abs(rolled), obstacle.remaining)
    obstacle.remaining -= part
    state.travel[obstacle.wheel] -= math.copysign(obstacle.lost * part / obstacle.span, rolled)
