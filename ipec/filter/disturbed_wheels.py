"""Which wheel was disturbed: a test of the innovations, wheel by wheel; compiled.

A wheel that loses travel, on a bump or by spinning, changes joint angles and link length in a ratio that
differs from wheel to wheel. Where the loss of a wheel explains innovations that noise does not explain, that
wheel is distrusted as long as it may be on the bump, and the linkage and the other wheels determine the
estimate.
"""

import numpy as np

from omnimate.ipec.filter.measurement import innovation, spread
from omnimate.ipec.filter.prediction import add_input
from omnimate.ipec.filter.records import JOINT_A, FilterSettings, FilterState
from omnimate.vehicle.compiled import Array, compiled

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
    """Return how much of the squared innovation a wheel's loss explains; 0 where it would have to be a gain.

    Args:
        state: Predicted estimate.
        wheel: Number of the wheel in `WHEELS`.
        information: Inverse covariance of the innovations, shape `(3, 3)`.
        pull: Product of `information` and the innovations, shape `(3,)`.
    """
    if state.travel[wheel] == 0.0 or state.alert[wheel] > 0.0:
        return 0.0
    along, weight = 0.0, 0.0
    for i in range(3):
        by_wheel = state.inputs[JOINT_A + i, wheel]
        along += by_wheel * pull[i]
        for j in range(3):
            weight += by_wheel * information[i, j] * state.inputs[JOINT_A + j, wheel]
    loses = along * state.travel[wheel] < 0.0
    return along * along / weight if loses else 0.0


@compiled
def find_disturbed(settings: FilterSettings, state: FilterState) -> None:
    """Distrust the wheels that explain what noise does not explain; keep the innovations' size as `nis`."""
    offsets = np.empty(3)
    for number in range(3):
        offsets[number] = innovation(state, number)
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
