"""The OmniMate's correction, O (1)-(6): truck a against the linkage, truck b from the kinematic chain.

The print errs twice, and each slip can be switched on. Its (1) takes truck b's previous position, from
which the link's heading lags behind in every turn; b must first advance by its own increment. Its (2)
to (4) take the joint's angle with the other sign, so that the error is added instead of taken away.
"""

from ipec.geometry import beyond, direction, follow, wrap
from ipec.records import Settings, State
from vehicle.compiled import compiled


@compiled
def correct_omnimate(settings: Settings, state: State) -> None:
    """Correct the poses of one sample, both trucks advanced by their own wheels before."""
    heading = direction(state.pose[0], state.pose[1])
    if settings.previous_b:
        heading = direction(state.pose[0], state.previous_b)
    error = wrap(state.joint[0] - (state.pose[0, 2] - heading))
    own = state.pose[1, 2]
    state.correction[0] = beyond(error, settings.tolerance[0])
    if settings.printed_sign:
        state.correction[0] *= -1.0
    state.pose[0, 2] += state.correction[0]
    follow(state.pose[1], state.pose[0], state.length, heading)
    state.correction[1] = beyond(wrap(heading + state.joint[1] - own), settings.tolerance[1])
    state.pose[1, 2] += state.correction[1]
