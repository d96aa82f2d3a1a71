"""The smoother's compiled passes: the filter forward again, block by block, and the adjoint backward.

A first pass has kept the filter's state at the start of each block, so that the steps of one block at a time
are in memory, however long the recording is.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.adjoint import Adjoint, undo_linkage, undo_step, undo_update
from omnimate.ipec.filter.fixes import take_fixes
from omnimate.ipec.filter.poses import look
from omnimate.ipec.filter.records import POSE, STATES, FilterState
from omnimate.ipec.filter.step import advance
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

EVERY = 8  # samples for which a covariance is used: it changes slowly


@compiled
def run_block(
    settings: Record,
    mark: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    fixes: Record,
    steps: Record,
    first: int,
) -> None:
    """Run the filter over one block again, and keep every step of it.

    Args:
        settings: One record `(1,)` of `FilterSettings`.
        mark: State before the block, one record `(1,)` of `FilterState`; changed in place.
        counts: Counts of the whole recording in the order of `CHANNELS`, shape `(N, 7)`.
        present: Whether each count was read, shape `(N, 7)`.
        fixes: Absolute poses of the whole recording, `(K,)` records of `Fix`; their gains are filled again.
        steps: Filled with the state after each sample of the block, `(M,)` records of `FilterState`.
        first: Number of the block's first sample.
    """
    following = 0
    while following < len(fixes) and fixes[following].sample < first:
        following += 1
    for place in range(len(steps)):
        advance(settings[0], mark[0], counts[first + place], present[first + place])
        following = take_fixes(mark[0], fixes, first + place, following)
        steps[place] = mark[0]


@compiled
def smoothed_mean(adjoint: Adjoint, step: FilterState, mean: Array) -> None:
    """Fill the smoothed mean `(6,)` of the first six states: x + P r."""
    for row in range(POSE):
        mean[row] = step.mean[row]
        for column in range(STATES):
            mean[row] += step.covariance[row, column] * adjoint.vector[column]


@compiled
def smoothed_covariance(adjoint: Adjoint, step: FilterState, covariance: Array) -> None:
    """Fill the smoothed covariance `(6, 6)` of the first six states: P - P L P."""
    rows = step.covariance
    carried = np.zeros((POSE, STATES))
    for row in range(POSE):
        for middle in range(STATES):
            for column in range(STATES):
                carried[row, column] += rows[row, middle] * adjoint.information[middle, column]
    for row in range(POSE):
        for column in range(POSE):
            total = rows[row, column]
            for middle in range(STATES):
                total -= carried[row, middle] * rows[column, middle]
            covariance[row, column] = total


@compiled
def smooth_block(
    steps: Record, adjoints: Record, fixes: Record, first: int, poses: Array, sigmas: Array, lost: Array
) -> None:
    """Run backward through one block.

    Args:
        steps: State after each sample of the block, `(M,)` records of `FilterState`.
        adjoints: Adjoint after the block, one record `(1,)`; changed to that before the block.
        fixes: Absolute poses of the whole recording with their gains, `(K,)` records of `Fix`.
        first: Number of the block's first sample.
        poses: Filled with the poses of truck a and b in the block [m, m, rad], shape `(2, N, 3)`.
        sigmas: Filled with their standard deviations, shape `(2, N, 3)`.
        lost: Filled with the travel that each wheel lost [m], shape `(N, 4)`.
    """
    adjoint = adjoints[0]
    mean, covariance = np.empty(STATES), np.empty((POSE, POSE))
    last = len(fixes) - 1
    for place in range(len(steps) - 1, -1, -1):
        step, sample = steps[place], first + place
        smoothed_mean(adjoint, step, mean)
        if sample % EVERY == 0 or place == len(steps) - 1:
            smoothed_covariance(adjoint, step, covariance)
        for truck in range(2):
            look(mean, covariance, truck, poses[truck, sample], sigmas[truck, sample])
        if not step.placed:
            poses[1, sample], sigmas[1, sample] = math.nan, math.nan
        while last >= 0 and fixes[last].sample > sample:
            last -= 1
        while last >= 0 and fixes[last].sample == sample:
            for number in range(2, -1, -1):
                undo_update(adjoint, fixes[last].row[number], fixes[last].gain[number])
            last -= 1
        if step.predicted:
            undo_linkage(adjoint, step)
            find_lost(adjoint, step, lost[sample])
            undo_step(adjoint, step.transition)


@compiled
def find_lost(adjoint: Adjoint, step: FilterState, lost: Array) -> None:
    """Fill what each wheel lost in one sample [m] `(4,)`: Q G' r against the travel."""
    for wheel in range(4):
        drawn = 0.0
        for row in range(POSE):
            drawn += step.inputs[row, wheel] * adjoint.vector[row]
        lost[wheel] = -math.copysign(step.input_variance[wheel], step.travel[wheel]) * drawn
