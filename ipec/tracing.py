"""The filter's compiled loop over a whole recording, with the absolute fixes that belong to it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

from ipec.filtering import advance, fill_pose_rows, fix_one, look
from vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ipec.filter_records import FilterState


BLOCK = 1024  # samples after which the filter's state is kept


class Fix:
    """An absolute pose, after the linkage of a sample has been taken.

    Attributes:
        sample: its number.
        truck: 0 for a, 1 for b.
        pose: nan where unknown.
        sigma: standard deviations.
        row: derivative of each coordinate by the states, where the filter took it.
        gain: as in `FilterState`.
    """

    sample: int
    truck: int
    pose: Annotated[Array, 3]
    sigma: Annotated[Array, 3]
    row: Annotated[Array, (3, 15)]
    gain: Annotated[Array, (3, 17)]


@compiled
def take_fixes(state: FilterState, fixes: Record, sample: int, following: int) -> int:
    """Take the fixes of a sample, in order; return the number of the next fix."""
    while following < len(fixes) and fixes[following].sample <= sample:
        fix = fixes[following]
        for number in range(3):
            fill_pose_rows(state.mean, fix.truck, fix.row)
            fix_one(state, fix.truck, number, fix.pose[number], fix.sigma[number], fix.gain[number])
        following += 1
    return following


@compiled
def trace_filter(
    settings: Record,
    states: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    fixes: Record,
    marks: Record,
    poses: Array,
    sigmas: Array,
    lost: Array,
    alert: Array,
    nis: Array,
) -> None:
    """Run the filter over all samples, and keep its state before each block of `BLOCK` samples.

    Fills poses and sigmas `(2, N, 3)`, lost and alert `(N, 4)`, nis `(N,)` and marks `(N / BLOCK,)`.
    """
    state, following = states[0], 0
    for sample in range(len(counts)):
        if sample % BLOCK == 0:
            marks[sample // BLOCK] = state
        advance(settings[0], state, counts[sample], present[sample])
        following = take_fixes(state, fixes, sample, following)
        for truck in range(2):
            look(state.mean, state.covariance, truck, poses[truck, sample], sigmas[truck, sample])
        if not state.placed:
            poses[1, sample], sigmas[1, sample] = math.nan, math.nan
        lost[sample], alert[sample], nis[sample] = state.lost, state.alert, state.nis
