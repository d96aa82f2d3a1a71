"""The smoother's compiled passes: the filter forward, block by block, and the adjoint states backward.

Modified Bryson-Frazier form (Bierman, 1973): the adjoint r and its information L run backward through
the filter's own steps, and the smoothed estimate is x + P r, with covariance P - P L P: no matrix is
inverted. A first pass keeps the filter's state at the start of each block, so that the steps of one
block at a time are kept, however long the recording.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import numpy as np

from ipec.filter_records import JOINT_A, JOINT_BIAS, POSE, STATES, FilterState
from ipec.filtering import advance, look
from ipec.tracing import take_fixes
from vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Adjoint:
    """What runs backward.

    Attributes:
        vector: r, `(15,)`.
        information: L, `(15, 15)`.
    """

    vector: Annotated[Array, 15]
    information: Annotated[Array, (15, 15)]


@compiled
def mark_blocks(
    settings: Record,
    states: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    fixes: Record,
    marks: Record,
    size: int,
) -> None:
    """Run the filter over all samples; keep its state before each block of `size` samples."""
    following = 0
    for sample in range(len(counts)):
        if sample % size == 0:
            marks[sample // size] = states[0]
        advance(settings[0], states[0], counts[sample], present[sample])
        following = take_fixes(states[0], fixes, sample, following)


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
    """Run the filter over one block again, and keep every step of it."""
    following = 0
    while following < len(fixes) and fixes[following].sample < first:
        following += 1
    for place in range(len(steps)):
        advance(settings[0], mark[0], counts[first + place], present[first + place])
        following = take_fixes(mark[0], fixes, first + place, following)
        steps[place] = mark[0]


@compiled
def undo_update(adjoint: Adjoint, row: Array, gain: Array) -> None:
    """Take the adjoint back through one scalar update whose reading has the derivative `row` `(15,)`."""
    push, weight = gain[STATES], gain[STATES + 1]
    vector, information = adjoint.vector, adjoint.information
    along = 0.0
    carried = np.zeros(STATES)
    for one in range(STATES):
        along += gain[one] * vector[one]
        for other in range(STATES):
            carried[one] += information[one, other] * gain[other]
    total = 0.0
    for one in range(STATES):
        total += gain[one] * carried[one]
    total = weight * (1.0 + weight * total)
    for one in range(STATES):
        vector[one] += row[one] * (push - weight * along)
        for other in range(STATES):
            information[one, other] += row[one] * row[other] * total - weight * (
                row[one] * carried[other] + carried[one] * row[other]
            )


@compiled
def undo_step(adjoint: Adjoint, step: FilterState) -> None:
    """Take the adjoint back through one prediction."""
    vector, information, transition = adjoint.vector, adjoint.information, step.transition
    before = np.zeros(STATES)
    half = np.zeros((STATES, STATES))  # L F
    for column in range(POSE, STATES):
        before[column] = vector[column]
    for row in range(POSE):
        for column in range(STATES):
            before[column] += transition[row, column] * vector[row]
    for row in range(STATES):
        for column in range(POSE, STATES):
            half[row, column] = information[row, column]
        for middle in range(POSE):
            factor = information[row, middle]
            for column in range(STATES):
                half[row, column] += factor * transition[middle, column]
    for row in range(STATES):
        vector[row] = before[row]
        for column in range(STATES):
            information[row, column] = half[row, column] if row >= POSE else 0.0
    for middle in range(POSE):
        for row in range(STATES):
            factor = transition[middle, row]
            if factor != 0.0:
                for column in range(STATES):
                    information[row, column] += factor * half[middle, column]


@compiled
def undo_linkage(adjoint: Adjoint, step: FilterState) -> None:
    """Take the adjoint back through the updates by link, joint_b and joint_a."""
    row = np.zeros(STATES)
    for number in range(2, -1, -1):
        if step.updated[number]:
            row[JOINT_A + number] = row[JOINT_BIAS + number] = 1.0
            undo_update(adjoint, row, step.gain[number])
            row[JOINT_A + number] = row[JOINT_BIAS + number] = 0.0


@compiled
def smoothed(adjoint: Adjoint, step: FilterState, mean: Array, covariance: Array) -> None:
    """Fill the smoothed mean `(15,)` and the covariance `(6, 6)` of the first six states."""
    rows = step.covariance
    carried = np.zeros((POSE, STATES))
    for row in range(STATES):
        mean[row] = step.mean[row]
        for column in range(STATES):
            mean[row] += rows[row, column] * adjoint.vector[column]
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
    """Run backward through one block; fill poses and sigmas `(2, N, 3)` and lost travel `(N, 4)`."""
    adjoint = adjoints[0]
    mean, covariance = np.empty(STATES), np.empty((POSE, POSE))
    last = len(fixes) - 1
    for place in range(len(steps) - 1, -1, -1):
        step, sample = steps[place], first + place
        smoothed(adjoint, step, mean, covariance)
        for truck in range(2):
            look(mean, covariance, truck, poses[truck, sample], sigmas[truck, sample])
        while last >= 0 and fixes[last].sample > sample:
            last -= 1
        while last >= 0 and fixes[last].sample == sample:
            for number in range(2, -1, -1):
                undo_update(adjoint, fixes[last].row[number], fixes[last].gain[number])
            last -= 1
        if step.predicted:
            undo_linkage(adjoint, step)
            for wheel in range(4):
                drawn = 0.0
                for row in range(POSE):
                    drawn += step.inputs[row, wheel] * adjoint.vector[row]
                way = math.copysign(1.0, step.travel[wheel])
                lost[sample, wheel] = -way * step.input_variance[wheel] * drawn
            undo_step(adjoint, step)
