"""The smoother's adjoint state, and its way back through the filter's updates and predictions; compiled.

Modified Bryson-Frazier form (Bierman, 1973): the adjoint r and its information L run backward through the
filter's own steps, and the smoothed estimate is x + P r, with covariance P - P L P. No matrix is inverted.
"""

from __future__ import annotations

from typing import Annotated

from omnimate.ipec.filter.prediction import returns_to
from omnimate.ipec.filter.records import JOINT_BIAS, LINK, POSE, STATES, WANDER, Step
from omnimate.vehicle.compiled import Array, compiled

MOVING = JOINT_BIAS - LINK  # states that the next step depends on, from the link's heading on


class Adjoint:
    """What runs backward.

    Attributes:
        vector: Adjoint r, shape `(19,)`.
        information: Information L of the adjoint, shape `(19, 19)`.
        change: Transition without its unit matrix, shape `(6, 14)`; working memory.
        drawn: Product of `change` and the information, shape `(14, 19)`; working memory.
        carried: One row of a product, shape `(19,)`; working memory.
    """

    vector: Annotated[Array, 19]
    information: Annotated[Array, (19, 19)]
    change: Annotated[Array, (6, 14)]
    drawn: Annotated[Array, (14, 19)]
    carried: Annotated[Array, 19]


@compiled
def undo_update(adjoint: Adjoint, row: Array, gain: Array) -> None:
    """Take the adjoint back through an update with a row `(19,)` and a gain `(21,)` as in `OpenFilter`."""
    push, weight = gain[STATES], gain[STATES + 1]
    vector, information, carried = adjoint.vector, adjoint.information, adjoint.carried
    along, total = 0.0, 0.0
    for i in range(STATES):
        drawn = 0.0
        for j in range(STATES):
            drawn += information[i, j] * gain[j]
        carried[i] = weight * drawn
        along += gain[i] * vector[i]
        total += gain[i] * carried[i]
    total = 0.5 * weight * (1.0 + total)
    for i in range(STATES):
        carried[i] -= total * row[i]
    for i in range(STATES):
        if row[i] == 0.0:
            continue
        vector[i] += row[i] * (push - weight * along)
        for j in range(STATES):
            change = row[i] * carried[j]
            information[i, j] -= change
            information[j, i] -= change


@compiled
def undo_linkage(adjoint: Adjoint, step: Step) -> None:
    """Take the adjoint back through the updates by link, joint_b and joint_a."""
    for number in range(2, -1, -1):
        if step.updated[number]:
            undo_update(adjoint, step.row[number], step.gain[number])


@compiled
def undo_wander(adjoint: Adjoint, lasting: float, reading: int) -> None:
    """Take the adjoint back through what a reading, or a heading by wheels, wandered in a step.

    `lasting` is the share of the error that outlasts the step; `reading` is as in `Step`.
    """
    vector, information, row = adjoint.vector, adjoint.information, WANDER
    if reading < 0:
        return
    joint = returns_to(reading)
    back = 1.0 - lasting if joint >= 0 else 0.0
    vector[row] = lasting * vector[row] + back * vector[joint]
    for column in range(STATES):
        information[row, column] = lasting * information[row, column] + back * information[joint, column]
    for column in range(STATES):
        information[column, row] = lasting * information[column, row] + back * information[column, joint]


@compiled
def undo_step(adjoint: Adjoint, transition: Array) -> None:
    """Take the adjoint back through one prediction: F' r and F' L F.

    With F = 1 + N they are r + N' r and L + H + H' + H N, where H = N' L. N has the rows of `POSE` and the
    columns from the link's heading to the creep: neither place nor biases move anything. `transition`
    `(6, 19)` are the first rows of F.
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
                for j in range(STATES):
                    drawn[column, j] += factor * information[row, j]
    for column in range(MOVING):
        vector[LINK + column] += pull[column]
    _add_to_information(adjoint)


@compiled
def _add_to_information(adjoint: Adjoint) -> None:
    """Add H + H' + H N to L, the last term by halves, so that L stays symmetric; H is `drawn`."""
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
