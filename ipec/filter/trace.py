"""The filter's compiled loop over a whole recording, with the absolute fixes that belong to it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.ipec.filter.fixes import take_fixes
from omnimate.ipec.filter.poses import look
from omnimate.ipec.filter.records import BELIEFS, POSE
from omnimate.ipec.filter.step import advance
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled_without_lock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


BLOCK = 1024  # samples after which the filter's state is kept


@compiled_without_lock
def trace_filter(
    settings: Record,
    states: Record,
    filters: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    fixes: Record,
    marks: Record,
    filter_marks: Record,
    poses: Array,
    sigmas: Array,
    lost: Array,
    alert: Array,
    nis: Array,
    means: Array,
    moves: Array,
) -> None:
    """Run the filter over all samples, and keep its state before each block of `BLOCK` samples.

    Args:
        settings: One record `(1,)` of `FilterSettings`.
        states: One record `(1,)` of `FilterState`; changed to the estimate after the last sample.
        filters: Open filters, `(H,)` records of `OpenFilter`; changed as well.
        counts: Counts in the order of `CHANNELS`, shape `(N, 7)`.
        present: Whether each count was read, shape `(N, 7)`.
        fixes: Absolute poses in order of time, `(K,)` records of `Fix`.
        marks: Filled with the state before each block, `(N / BLOCK,)` records of `FilterState`.
        filter_marks: Filled with the open filters before each block, `(N / BLOCK, H)` records.
        poses: Filled with the poses of truck a and b [m, m, rad], shape `(2, N, 3)`.
        sigmas: Filled with their standard deviations, shape `(2, N, 3)`.
        lost: Filled with the travel that each wheel lost [m], shape `(N, 4)`.
        alert: Filled with the travel for which each wheel stays distrusted [m], shape `(N, 4)`.
        nis: Filled with the normalised innovation squared, shape `(N,)`.
        means: Filled with the first six states, shape `(N, 6)`.
        moves: Filled with the way to what is believed, each time that it is decided, shape `(D, 20)`.
    """
    state, following = states[0], 0
    for sample in range(len(counts)):
        if sample % BLOCK == 0:
            marks[sample // BLOCK] = state
            for hypothesis in range(BELIEFS):
                filter_marks[sample // BLOCK, hypothesis] = filters[hypothesis]
        advance(settings[0], state, filters, counts[sample], present[sample], moves)
        following = take_fixes(settings[0], state, filters, fixes, sample, following, moves)
        for truck in range(2):
            look(state.mean, state.known, truck, poses[truck, sample], sigmas[truck, sample])
        if not state.placed:
            poses[1, sample], sigmas[1, sample] = math.nan, math.nan
        likely = filters[state.weight.argmax()]
        alert[sample] = likely.alert[:4]
        lost[sample], nis[sample] = 0.0, math.nan
        if state.predicted:
            lost[sample], nis[sample] = likely.lost, likely.nis
        means[sample] = state.mean[:POSE]
