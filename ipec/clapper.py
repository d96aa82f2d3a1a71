"""The CLAPPER's correction, C (10)-(16): both headings against the linkage, truck b put behind truck a.

A joint that reads in steps shows only that its angle lies within half a step of the reading. So only what
lies beyond half a step is an error; a heading that followed every reading would drift with it.
"""

import math

from omnimate.ipec.corrector_records import Settings, State
from omnimate.ipec.tolerance import beyond
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.linkage import direction, follow
from omnimate.vehicle.se2 import wrap_angle


@compiled
def correct_clapper(settings: Settings, state: State) -> None:
    """Correct the poses of one sample, both trucks advanced by their own wheels before, C (9)."""
    heading = direction(state.pose[0], state.pose[1])
    for truck in range(2):
        expected = state.pose[truck, 2] - heading
        error = wrap_angle(state.joint[truck] - expected)
        state.correction[truck] = beyond(error, settings.tolerance[truck])
        state.pose[truck, 2] += state.correction[truck]
    take_back(settings, state)
    follow(state.pose[1], state.pose[0], state.length, heading)


@compiled
def take_back(settings: Settings, state: State) -> None:
    """Move truck a against its travel by what the wheel that turned it has lost, C (14)-(15).

    A wheel can roll further than it travels, but not less. So the amount is |delta| and the direction is
    against the travel. The print uses delta with its sign, and forward travel only.
    """
    lost = settings.wheelbase[0] * math.sin(0.5 * abs(state.correction[0]))
    state.taken_back = math.copysign(1.0, state.travel[0] + state.travel[1]) * lost
    state.pose[0, 0] -= state.taken_back * math.cos(state.pose[0, 2])
    state.pose[0, 1] -= state.taken_back * math.sin(state.pose[0, 2])
