"""The smoother's adjoint recursion through the filter's updates and predictions; compiled.

Modified Bryson-Frazier form (Bierman, 1973): the adjoint r and its information L run backward through the
filter's own steps, and the smoothed estimate is x + P r, with covariance P - P L P. No matrix is inverted.
"""

from __future__ import annotations

from typing import Annotated

from omnimate.ipec.filter.prediction import restored_joint
from omnimate.ipec.filter.records import JOINT_BIAS, LINK, POSE, STATES, WANDER, Step
from omnimate.vehicle.compiled import Array, compiled

MOVING = JOINT_BIAS - LINK  # states that the next step depends on, from the link's heading on


class Adjoint:
    """State of the backward recursion."""

    vector: Annotated[Array, 19]  # adjoint r
    information: Annotated[Array, (19, 19)]  # information L of the adjoint
    change: Annotated[Array, (6, 14)]  # transition without its unit matrix; working memory
    drawn: Annotated[Array, (14, 19)]  # product of `change` and the information; working memory
    carried: Annotated[Array, 19]  # one row of a product; working memory


@compiled
def undo_update(adjoint: Adjoint, row: Array, gain: Array) -> None:
    """Propagate the adjoint backward through an update with row `(19,)` and gain `(21,)` of `OpenFilter`."""
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
    """Propagate the adjoint backward through the updates by link, joint_b and joint_a."""
    for number in range(2, -1, -1):
        if step.updated[number]:
            undo_update(adjoint, step.row[number], step.gain[number])


@compiled
def undo_decay(adjoint: Adjoint, decay: float, reading: int) -> None:
    """Propagate the adjoint backward through one step of a Gauss-Markov error.

    `decay` is the error's correlation over the step; `reading` is as in `Step`.
    """
    vector, information, row = adjoint.vector, adjoint.information, WANDER
    if reading < 0:
        return
    joint = restored_joint(reading)
    restored = 1.0 - decay if joint >= 0 else 0.0
    vector[row] = decay * vector[row] + restored * vector[joint]
    for column in range(STATES):
        information[row, column] = decay * information[row, column] + restored * information[joint, column]
    for column in range(STATES):
        information[column, row] = decay * information[column, row] + restored * information[column, joint]


@compiled
def undo_step(adjoint: Adjoint, transition: Array) -> None:
    """Propagate the adjoint backward through one prediction: F' r and F' L F.

    With F = 1 + N they are r + N' r and L + H + H' + H N, where H = N' L. N has the rows of `POSE` and the
    columns from the link's heading to the creep: neither position nor biases act on the motion. `transition`
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
