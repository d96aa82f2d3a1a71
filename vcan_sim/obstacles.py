"""Obstacles of the floor: when a wheel meets one, and what travel the crossing costs in each step.

How long a crossing is and what it costs in all is the law of `crossing`. The floor's obstacles spread the
loss evenly over the way rolled; the effect `bump` follows its exact course, which a diagnosis can tell.
"""

import math

from omnimate.vcan_sim.records import Constants, Obstacle, State
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.se2 import transform_xy


@compiled
def touches(obstacle: Obstacle, constants: Constants, state: State) -> bool:
    """Return whether a wheel stands where an obstacle begins."""
    if obstacle.scheduled:
        if obstacle.lap >= 0:
            return bool(obstacle.lap == state.lap and state.rolled[1, obstacle.wheel] >= obstacle.after)
        return bool(state.rolled[0, obstacle.wheel] >= obstacle.after)
    truck, right = obstacle.wheel // 2, obstacle.wheel % 2
    arm = constants.wheelbase[truck] * (0.5 - right)
    x, y = transform_xy(state.pose[truck], 0.0, arm)
    return math.hypot(x - obstacle.x, y - obstacle.y) <= obstacle.size


@compiled
def lose_travel(obstacle: Obstacle, constants: Constants, state: State) -> None:
    """Take off a wheel's travel what one obstacle costs in this step, spread evenly over the crossing."""
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
