"""One sample of the filter: predict; at the end of a step find disturbances, update, and mix; compiled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.disturbed_wheels import STEP, find_disturbed, find_levels
from omnimate.ipec.filter.forms import follow_motion, shape_error
from omnimate.ipec.filter.measurement import (
    apply_reading,
    compare,
    expected_reading,
    fill_rows,
    find_scatter,
)
from omnimate.ipec.filter.mixture import move_to_mixture
from omnimate.ipec.filter.prediction import (
    differentiate,
    find_input_variance,
    predict_covariance,
    predict_mean,
    wander,
)
from omnimate.ipec.filter.records import (
    BANK,
    ERRORS,
    INPUTS,
    JOINT_A,
    JOINT_BIAS,
    LINK,
    POSE,
    STATES,
    WANDER,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.ipec.readings import sense
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

SHORT = 0.0125  # [m], the same on a bump, which a wheel rolls over in 0.05 m
NOTHING, PLACE, FINISH = range(3)  # what the open filters have to do after a sample
STEADY = 1.0 / 200.0  # share of a sample in the learned scatter of the readings


@compiled
def place(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Read the linkage for the first time; until then the heading of truck a stands for the link's."""
    for number in range(3):
        reading = state.joint[number] if number < 2 else state.length
        state.mean[JOINT_A + number] = reading - state.mean[JOINT_BIAS + number]
    begin_step(state)
    _place(settings, state, state.known, np.zeros(ERRORS), np.zeros((ERRORS, 3)))
    for hypothesis in range(BANK):
        opened = filters[hypothesis]
        shape_error(settings, state, opened)
        _place(settings, state, opened.covariance, opened.variance, opened.share)
    state.mean[LINK] -= state.mean[JOINT_A]
    state.placed = 1
    begin_step(state)


@compiled
def _place(
    settings: FilterSettings, state: FilterState, covariance: Array, variance: Array, shares: Array
) -> None:
    """Fill what a first reading leaves open in a covariance `(19, 19)`.

    `variance` `(2,)` is that of the sizes of what errs; `shares` `(2, 3)` is by what joint_a, joint_b and the
    link change per unit of them.
    """
    for error in range(ERRORS):
        covariance[WANDER + error, WANDER + error] = variance[error]
    for number in range(3):
        true = JOINT_A + number
        covariance[true, true] = settings.half[number] ** 2 / 3.0 + state.blur[number]
        _read(covariance, true, JOINT_BIAS + number, 1.0)
        for error in range(ERRORS):
            _read(covariance, true, WANDER + error, shares[error, number])
    covariance[LINK, LINK] += covariance[JOINT_A, JOINT_A]
    covariance[LINK, JOINT_A] = covariance[JOINT_A, LINK] = -covariance[JOINT_A, JOINT_A]
    for error in (JOINT_BIAS, WANDER, WANDER + 1):
        covariance[LINK, error] = covariance[error, LINK] = -covariance[JOINT_A, error]


@compiled
def _read(covariance: Array, true: int, error: int, share: float) -> None:
    """Let a true value be what was read minus a share of an error, in a covariance `(19, 19)`."""
    covariance[true, true] += share * share * covariance[error, error]
    covariance[true, error] = covariance[error, true] = -share * covariance[error, error]


@compiled
def begin_step(state: FilterState) -> None:
    """Begin a step."""
    state.begun[:] = state.mean[LINK : LINK + 4]
    state.way[:] = 0.0
    state.rolled[:] = 0.0
    state.missed[:] = 0.0
    state.jumps[:] = 0.0
    state.samples = state.seen = 0


@compiled
def accumulate(settings: FilterSettings, state: FilterState) -> None:
    """Compare the readings of one sample with the estimate, and learn how they scatter."""
    state.seen += 1
    for number in range(3):
        missed = compare(state, number)
        jump = missed - state.late[number]
        # Noise that is fresh in each sample makes two changes in a row opposite; what moves does not.
        most = 9.0 * max(state.blur[number], settings.half[number] ** 2 / 3.0)
        noise = min(max(-jump * state.jump[number], -most), most)
        state.blur[number] = max(0.0, state.blur[number] + STEADY * (noise - state.blur[number]))
        state.missed[number] += missed
        state.jumps[number] += jump * jump
        state.late[number], state.jump[number] = missed, jump


@compiled
def has_ended(state: FilterState) -> bool:
    """Return whether a step has ended: it is shorter while a wheel is distrusted, as on a bump."""
    return bool(state.rolled.max() >= (SHORT if state.bumpy else STEP))


@compiled
def update(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Predict an open filter over a step, and update it by the readings."""
    opened.nis = math.nan
    opened.lost[:] = 0.0
    opened.updated[:] = 0
    shape_error(settings, state, opened)
    find_levels(settings, state, opened)
    find_input_variance(settings, state, opened)
    predict_covariance(settings, state, opened)
    wander(state, opened)
    rolled, alert = 0.25 * state.rolled.sum(), opened.alert
    for number in range(INPUTS):
        alert[number] = max(0.0, alert[number] - rolled)
    if state.seen == 0:
        return
    fill_rows(state, opened)
    find_disturbed(settings, state, opened)
    shares = state.shares
    shares[:] = 0.0
    for wheel in range(4):
        if alert[wheel] > 0.0:
            for row in range(POSE):
                shares[wheel, row] = opened.input_variance[wheel] * state.inputs[row, wheel]
    for number in range(3):
        apply_reading(state, opened, number)
    for wheel in range(4):
        opened.lost[wheel] *= -math.copysign(1.0, state.way[wheel])


@compiled
def finish_step(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """End a step: predict covariances, take the readings, and move to the mixture; `moves` as there."""
    state.predicted = 1
    state.went[:] = state.way
    differentiate(settings, state)
    follow_motion(settings, state)
    if state.seen > 0:
        find_scatter(settings, state)
    for hypothesis in range(BANK):
        if filters[hypothesis].followed:
            update(settings, state, filters[hypothesis])
    before = np.empty(3)
    for number in range(3):
        before[number] = expected_reading(state.mean, number)
    move_to_mixture(settings, state, filters, moves)
    for number in range(3):
        state.late[number] -= expected_reading(state.mean, number) - before[number]
    begin_step(state)


@compiled
def predict(
    settings: FilterSettings, state: FilterState, counts: IntArray, present: NDArray[np.bool_]
) -> int:
    """Move the estimate by one sample, and return what the open filters have to do: NOTHING, PLACE or FINISH.

    The trucks move only where all four wheels were read; counts and presence `(7,)` are in the order of
    `CHANNELS`.
    """
    state.shift[:] = 0.0
    state.predicted = 0
    if not (present[0] and present[1] and present[2] and present[3]):
        return NOTHING
    sense(settings, state, counts, present)
    if not state.placed:
        return PLACE if state.linked else NOTHING
    if not state.moved[0]:
        return NOTHING
    predict_mean(settings, state)
    state.samples += 1
    for wheel in range(4):
        state.way[wheel] += state.travel[wheel]
        state.rolled[wheel] += abs(state.travel[wheel])
    if state.linked:
        accumulate(settings, state)
    return FINISH if has_ended(state) else NOTHING


@compiled
def run_hypotheses(
    settings: FilterSettings, state: FilterState, filters: Record, todo: int, moves: Array
) -> None:
    """Let the open filters do what `predict` has returned; `moves` as in `move_to_mixture`."""
    if todo == PLACE:
        place(settings, state, filters)
    elif todo == FINISH:
        finish_step(settings, state, filters, moves)


@compiled
def advance(
    settings: FilterSettings,
    state: FilterState,
    filters: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    moves: Array,
) -> None:
    """Take one sample in place, with its open filters `(H,)`."""
    run_hypotheses(settings, state, filters, predict(settings, state, counts, present), moves)


@compiled
def finish_open_step(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """End the step that is under way, if the robot has moved in it; `moves` as in `move_to_mixture`."""
    if state.rolled.sum() > 0.0:
        finish_step(settings, state, filters, moves)


@compiled
def predict_live(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> int:
    """Return what `predict` returns, for settings and a state that are records `(1,)`."""
    return predict(settings[0], states[0], counts, present)


@compiled
def run_hypotheses_live(settings: Record, states: Record, filters: Record, todo: int) -> None:
    """Let the open filters do what `predict_live` has returned, in place."""
    run_hypotheses(settings[0], states[0], filters, todo, np.empty((0, STATES + 1)))
