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

from ipec.filter_records import JOINT_A, JOINT_BIAS, LINK, POSE, STATES, FilterState
from ipec.filtering import advance, look
from ipec.tracing import take_fixes
from vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray


MOVING = JOINT_BIAS - LINK  # states that the next step depends on, from the link's heading on
EVERY = 8  # samples for which one covariance stands: it changes slowly


class Adjoint:
    """What runs backward.

    Attributes:
        vector: r, `(15,)`.
        information: L, `(15, 15)`.
        change: N, the transition without its unit matrix, `(6, 10)`; this and what follows is scratch.
        drawn: `(10, 15)`.
        carried: `(15,)`.
    """

    vector: Annotated[Array, 15]
    information: Annotated[Array, (15, 15)]
    change: Annotated[Array, (6, 10)]
    drawn: Annotated[Array, (10, 15)]
    carried: Annotated[Array, 15]


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
def undo_reading(adjoint: Adjoint, number: int, gain: Array) -> None:
    """Take the adjoint back through the update by joint_a, joint_b or link, which reads true + bias only."""
    push, weight = gain[STATES], gain[STATES + 1]
    vector, information, carried = adjoint.vector, adjoint.information, adjoint.carried
    along, total = 0.0, 0.0
    for one in range(STATES):
        drawn = 0.0
        for other in range(STATES):
            drawn += information[one, other] * gain[other]
        carried[one] = weight * drawn
        along += gain[one] * vector[one]
        total += gain[one] * carried[one]
    total = weight * (1.0 + total)
    for own in (JOINT_A + number, JOINT_BIAS + number):
        vector[own] += push - weight * along
        for other in range(STATES):
            information[own, other] -= carried[other]
            information[other, own] -= carried[other]
        information[own, JOINT_A + number] += total
        information[own, JOINT_BIAS + number] += total


@compiled
def undo_step(adjoint: Adjoint, transition: Array) -> None:
    """Take the adjoint back through one prediction: F' r and F' L F.

    With F = 1 + N they are r + N' r and L + H + H' + H N, where H = N' L. N has the rows of `POSE` and the
    columns from the link's heading to the wheelbases: neither place nor biases move anything.
    """
    vector, information = adjoint.vector, adjoint.information
    change, drawn, pull = adjoint.change, adjoint.drawn, adjoint.carried
    drawn[:] = 0.0
    pull[:] = 0.0
    for row in range(POSE):
        for column in range(MOVING):
            change[row, column] = transition[row, LINK + column]
        if row >= LINK:
            change[row, row - LINK] -= 1.0
        for column in range(MOVING):
            factor = change[row, column]
            pull[column] += factor * vector[row]
            if factor != 0.0:
                for other in range(STATES):
                    drawn[column, other] += factor * information[row, other]
    for column in range(MOVING):
        vector[LINK + column] += pull[column]
    spread_information(adjoint)


@compiled
def spread_information(adjoint: Adjoint) -> None:
    """Add H + H' + H N to L, the last one by halves, so that L stays symmetric; H is `drawn`."""
    information, change, drawn, whole = adjoint.information, adjoint.change, adjoint.drawn, adjoint.carried
    for row in range(MOVING):
        whole[:] = drawn[row]
        for middle in range(POSE):
            factor = 0.5 * drawn[row, middle]
            for column in range(MOVING):
                whole[LINK + column] += factor * change[middle, column]
        for column in range(STATES):
            information[LINK + row, column] += whole[column]
            information[column, LINK + row] += whole[column]


@compiled
def undo_linkage(adjoint: Adjoint, step: FilterState) -> None:
    """Take the adjoint back through the updates by link, joint_b and joint_a."""
    for number in range(2, -1, -1):
        if step.updated[number]:
            undo_reading(adjoint, number, step.gain[number])


@compiled
def smoothed_mean(adjoint: Adjoint, step: FilterState, mean: Array) -> None:
    """Fill the smoothed mean of the first six states: x + P r."""
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
    """Run backward through one block; fill poses and sigmas `(2, N, 3)` and lost travel `(N, 4)`."""
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
