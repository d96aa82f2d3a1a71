"""One sample of a corrector, compiled, and the loop over a whole recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.ipec.clapper import correct_clapper
from omnimate.ipec.corrector_records import CLAPPER, OMNIMATE, Settings, State
from omnimate.ipec.omnimate import correct_omnimate
from omnimate.ipec.readings import sense
from omnimate.vehicle.arcs import roll
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.linkage import follow

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@compiled
def place(state: State) -> None:
    """Put truck b behind truck a where the linkage is read for the first time."""
    heading = state.pose[0, 2] - state.joint[0]
    follow(state.pose[1], state.pose[0], state.length, heading)
    state.pose[1, 2] = heading + state.joint[1]
    state.placed = 1


@compiled
def advance(settings: Settings, state: State, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Take one sample: dead-reckon both trucks, C (9), then correct them where all encoders were read.

    Args:
        settings: Settings of the corrector.
        state: State before the sample; changed to that after it.
        counts: Counts in the order of `CHANNELS`, shape `(7,)`.
        present: Whether each count was read, shape `(7,)`.
    """
    sense(settings, state, counts, present)
    state.correction[:] = 0.0
    state.taken_back = 0.0
    for truck in range(2):
        left, right = state.travel[2 * truck], state.travel[2 * truck + 1]
        if state.moved[truck]:
            roll(state.pose[truck], left, right, settings.wheelbase[truck])
    if state.linked and not state.placed:
        place(state)
    elif state.linked and state.moved[0] and state.moved[1]:
        if settings.law == CLAPPER:
            correct_clapper(settings, state)
        elif settings.law == OMNIMATE:
            correct_omnimate(settings, state)


@compiled
def advance_one(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Take one sample `(7,)` of a live stream, in place; `settings` and `states` are records `(1,)`."""
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
    """Take all samples of a recording.

    Args:
        settings: One record `(1,)` of `Settings`.
        states: One record `(1,)` of `State`; changed to the state after the last sample.
        counts: Counts in the order of `CHANNELS`, shape `(N, 7)`.
        present: Whether each count was read, shape `(N, 7)`.
        poses: Filled with the poses of truck a and b [m, m, rad], shape `(2, N, 3)`.
        corrections: Filled with the corrections of both headings [rad], and the travel taken back [m].
    """
    state = states[0]
    for sample in range(len(counts)):
        advance(settings[0], state, counts[sample], present[sample])
        for truck in range(2):
            poses[truck, sample] = state.pose[truck]
            corrections[sample, truck] = state.correction[truck]
        corrections[sample, 2] = state.taken_back
