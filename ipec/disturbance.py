"""Which wheel was disturbed: a test of the innovations, wheel by wheel.

A wheel that lost travel, on a bump or by spinning, moves joint angles and link length in a direction
of its own. Where one loss explains innovations that noise does not, the wheel is distrusted while it
may still be on the bump, and the linkage and the other wheels carry the estimate.
"""

import numpy as np

from ipec.filter_records import JOINT_A, FilterSettings, FilterState
from ipec.measurement import innovation, spread
from ipec.prediction import add_input
from vehicle.compiled import Array, compiled

AMBIGUOUS = 4.0  # [squared standard deviations] within which two wheels explain equally well


@compiled
def inverted(matrix: Array) -> Array:
    """Return the inverse of a symmetric positive matrix `(3, 3)`."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    out = np.empty((3, 3))
    out[0, 0], out[0, 1], out[0, 2] = d * f - e * e, c * e - b * f, b * e - c * d
    out[1, 1], out[1, 2], out[2, 2] = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * out[0, 0] + b * out[0, 1] + c * out[0, 2]
    for row in range(3):
        for column in range(row, 3):
            out[row, column] /= determinant
            out[column, row] = out[row, column]
    return out


@compiled
def explain(state: FilterState, wheel: int, information: Array, pull: Array) -> float:
    """Return how much of the squared innovation one wheel's loss explains; 0 where it would be a gain.

    Args:
        state: predicted.
        wheel: number of the wheel.
        information: `(3, 3)` inverse covariance of the innovations.
        pull: `(3,)` that times the innovations.
    """
    if state.travel[wheel] == 0.0 or state.alert[wheel] > 0.0:
        return 0.0
    along, weight = 0.0, 0.0
    for one in range(3):
        own = state.inputs[JOINT_A + one, wheel]
        along += own * pull[one]
        for other in range(3):
            weight += own * information[one, other] * state.inputs[JOINT_A + other, wheel]
    loses = along * state.travel[wheel] < 0.0
    return along * along / weight if loses else 0.0


@compiled
def find_disturbed(settings: FilterSettings, state: FilterState) -> None:
    """Distrust the wheels that explain what noise does not; leave the innovations' size in the state."""
    offsets = np.empty(3)
    for one in range(3):
        offsets[one] = innovation(state, one)
    scores = np.empty(4)
    for attempt in range(3):
        information = inverted(spread(settings, state))
        pull = information @ offsets
        if attempt == 0:
            state.nis = float(pull @ offsets)
        for wheel in range(4):
            scores[wheel] = explain(state, wheel, information, pull)
        best = scores.max()
        if best < settings.gate:
            return
        for wheel in range(4):
            if scores[wheel] >= best - AMBIGUOUS and scores[wheel] > 0.0:
                _distrust(settings, state, wheel)


@compiled
def _distrust(settings: FilterSettings, state: FilterState, wheel: int) -> None:
    state.alert[wheel] = settings.hold
    variance = (settings.distrust * state.travel[wheel]) ** 2
    state.input_variance[wheel] += variance
    add_input(state, wheel, variance)
