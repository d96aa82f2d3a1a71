"""The OmniMate's correction, O (1)-(6): truck a against the linkage, truck b from the kinematic chain.

The print has two errors, which are corrected here. Its (1) uses truck b's previous position, so that the
link's heading lags behind in every turn; b must first advance by the travel of its wheels. Its (2) to (4) use
the joint's angle with the other sign, so that the error is added instead of removed.
"""

from omnimate.ipec.corrector_records import Settings, State
from omnimate.ipec.tolerance import beyond
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.linkage import direction, follow
from omnimate.vehicle.se2 import wrap_angle


@compiled
def correct_omnimate(settings: Settings, state: State) -> None:
    """Correct the poses of one sample, both trucks advanced by their own wheels before."""
    heading = direction(state.pose[0], state.pose[1])
    error = wrap_angle(state.joint[0] - (state.pose[0, 2] - heading))
    heading_b = state.pose[1, 2]
    state.correction[0] = beyond(error, settings.tolerance[0])
    state.pose[0, 2] += state.correction[0]
    follow(state.pose[1], state.pose[0], state.length, heading)
    state.correction[1] = beyond(wrap_angle(heading + state.joint[1] - heading_b), settings.tolerance[1])
    state.pose[1, 2] += state.correction[1]
