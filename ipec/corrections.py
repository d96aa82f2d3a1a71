"""The equations of the correctors, compiled: CLAPPER, C (9)-(16), and OmniMate, O (1)-(6).

A quantised joint reading only bounds the angle to within half a count. So only a deviation beyond that
tolerance is corrected; correcting every deviation would integrate the quantisation into the heading.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from omnimate.ipec.readings import Reading, Scales, convert_counts
from omnimate.vehicle.arcs import roll
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.linkage import link_heading, place_follower
from omnimate.vehicle.se2 import wrap_angle

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PLAIN, CLAPPER, OMNIMATE = range(3)


class Settings(Scales):
    """Constants of a corrector."""

    law: int  # equations: PLAIN, CLAPPER or OMNIMATE
    # Error of each truck's heading that is not corrected [rad]: half a count of the joint plus the resolution
    # of the wheels
    tolerance: Annotated[Array, 2]


class State(Reading):
    """The last sample and the poses after it."""

    placed: int  # 1 once truck b's pose has been initialised from the linkage
    pose: Annotated[Array, (2, 3)]  # poses of truck a and b [m, m, rad]
    correction: Annotated[Array, 2]  # correction of both headings in this sample [rad]
    taken_back: float  # travel of truck a taken back in this sample, C (14) [m]


@compiled
def excess_over_tolerance(error: float, tolerance: float) -> float:
    """Return the part of an error that exceeds a tolerance (a dead zone), in the same unit."""
    return error - min(max(error, -tolerance), tolerance)


@compiled
def correct_clapper(settings: Settings, state: State) -> None:
    """Correct both headings by the linkage, then place truck b; call it after dead reckoning, C (9)."""
    heading = link_heading(state.pose[0], state.pose[1])
    for truck in range(2):
        expected = state.pose[truck, 2] - heading
        error = wrap_angle(state.joint[truck] - expected)
        state.correction[truck] = excess_over_tolerance(error, settings.tolerance[truck])
        state.pose[truck, 2] += state.correction[truck]
    take_back_lost_travel(settings, state)
    place_follower(state.pose[1], state.pose[0], state.length, heading)


@compiled
def take_back_lost_travel(settings: Settings, state: State) -> None:
    """Move truck a back by the travel that the disturbed wheel lost, C (14)-(15).

    A wheel on a bump rolls further than it travels, never less: the amount depends on |delta|, and the
    direction is opposite to the travel. The paper uses signed delta, and forward travel only.
    """
    lost = settings.wheelbase[0] * math.sin(0.5 * abs(state.correction[0]))
    state.taken_back = math.copysign(1.0, state.travel[0] + state.travel[1]) * lost
    state.pose[0, 0] -= state.taken_back * math.cos(state.pose[0, 2])
    state.pose[0, 1] -= state.taken_back * math.sin(state.pose[0, 2])


@compiled
def correct_omnimate(settings: Settings, state: State) -> None:
    """Correct the poses of one sample by O (1)-(6); call it after dead reckoning of both trucks.

    Two errors of the paper are corrected here. Its (1) uses truck b's previous position, so that the link's
    heading lags in every turn; b must first advance by the travel of its wheels. Its (2) to (4) use the joint
    angle with the opposite sign, so that the error is added instead of removed.
    """
    heading = link_heading(state.pose[0], state.pose[1])
    error = wrap_angle(state.joint[0] - (state.pose[0, 2] - heading))
    heading_b = state.pose[1, 2]
    state.correction[0] = excess_over_tolerance(error, settings.tolerance[0])
    state.pose[0, 2] += state.correction[0]
    place_follower(state.pose[1], state.pose[0], state.length, heading)
    state.correction[1] = excess_over_tolerance(
        wrap_angle(heading + state.joint[1] - heading_b), settings.tolerance[1]
    )
    state.pose[1, 2] += state.correction[1]


@compiled
def initialise_truck_b(state: State) -> None:
    """Initialise the pose of truck b from the first reading of the linkage."""
    heading = state.pose[0, 2] - state.joint[0]
    place_follower(state.pose[1], state.pose[0], state.length, heading)
    state.pose[1, 2] = heading + state.joint[1]
    state.placed = 1


@compiled
def advance(settings: Settings, state: State, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Process one sample: dead-reckon both trucks, C (9), and correct them if all encoders were read.

    `state` is changed in place; counts and presence `(7,)` are in the order of `CHANNELS`.
    """
    convert_counts(settings, state, counts, present)
    state.correction[:] = 0.0
    state.taken_back = 0.0
    for truck in range(2):
        left, right = state.travel[2 * truck], state.travel[2 * truck + 1]
        if state.moved[truck]:
            roll(state.pose[truck], left, right, settings.wheelbase[truck])
    if state.linked and not state.placed:
        initialise_truck_b(state)
    elif state.linked and state.moved[0] and state.moved[1]:
        if settings.law == CLAPPER:
            correct_clapper(settings, state)
        elif settings.law == OMNIMATE:
            correct_omnimate(settings, state)


@compiled
def advance_one(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Process one sample `(7,)` of a live stream, in place; `settings` and `states` are records `(1,)`."""
    advance(settings[0], states[0], counts, present)


@compiled
def advance_all(
    settings: Record,
    states: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    poses: Array,
    corrections: Array,
) -> None:
    """Process all samples of a recording: counts and presence `(N, 7)` in the order of `CHANNELS`.

    `settings` and `states` are records `(1,)`; the state becomes that after the last sample. Filled are the
    `poses` `(2, N, 3)` of truck a and b [m, m, rad], and in `corrections` `(N, 3)` those of both headings
    [rad] and the travel taken back [m].
    """
    state = states[0]
    for sample in range(len(counts)):
        advance(settings[0], state, counts[sample], present[sample])
        for truck in range(2):
            poses[truck, sample] = state.pose[truck]
            corrections[sample, truck] = state.correction[truck]
        corrections[sample, 2] = state.taken_back
