"""One sample of the filter: predict; at the end of a step find disturbances, update, and believe."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.belief import settle
from omnimate.ipec.filter.disturbed_wheels import STEP, find_disturbed, find_levels
from omnimate.ipec.filter.forms import follow_motion, shape_error
from omnimate.ipec.filter.measurement import compare, expected_reading, fill_rows, find_scatter, update
from omnimate.ipec.filter.prediction import (
    differentiate,
    find_input_variance,
    predict_covariance,
    predict_mean,
    wander,
)
from omnimate.ipec.filter.records import (
    BELIEFS,
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
NOTHING, PLACE, CLOSE = range(3)  # what the open filters have to do after a sample
STEADY = 1.0 / 200.0  # share of a sample in the learned scatter of the readings


@compiled
def place(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Read the linkage for the first time; until then the heading of truck a stands for the link's."""
    for number in range(3):
        reading = state.joint[number] if number < 2 else state.length
        state.mean[JOINT_A + number] = reading - state.mean[JOINT_BIAS + number]
    begin(state)
    _place(settings, state, state.known, np.zeros(ERRORS), np.zeros((ERRORS, 3)))
    for hypothesis in range(BELIEFS):
        opened = filters[hypothesis]
        shape_error(settings, state, opened)
        _place(settings, state, opened.covariance, opened.variance, opened.share)
    state.mean[LINK] -= state.mean[JOINT_A]
    state.placed = 1
    begin(state)


@compiled
def _place(
    settings: FilterSettings, state: FilterState, covariance: Array, variance: Array, shares: Array
) -> None:
    """Fill what a first reading leaves open in a covariance `(19, 19)`.

    Args:
        settings: Settings of the filter.
        state: Estimate.
        covariance: Filled.
        variance: Variance of the sizes of what errs, shape `(2,)`.
        shares: By what joint_a, joint_b and link change per unit of them, shape `(2, 3)`.
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
def begin(state: FilterState) -> None:
    """Begin a step."""
    for number in range(4):
        state.begun[number] = state.mean[LINK + number]
    state.way[:] = 0.0
    state.rolled[:] = 0.0
    state.missed[:] = 0.0
    state.jumps[:] = 0.0
    state.samples = state.seen = 0


@compiled
def watch(settings: FilterSettings, state: FilterState) -> None:
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
def take(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Carry an open filter over a step, and let it take the readings."""
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
        update(state, opened, number)
    for wheel in range(4):
        opened.lost[wheel] *= -math.copysign(1.0, state.way[wheel])


@compiled
def close(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """End a step: carry the covariance on, take the readings, and move the estimate to what is believed.

    `moves` `(D, 20)` is what `settle` takes.
    """
    state.predicted = 1
    state.went[:] = state.way
    differentiate(settings, state)
    follow_motion(settings, state)
    if state.seen > 0:
        find_scatter(settings, state)
    for hypothesis in range(BELIEFS):
        if filters[hypothesis].followed:
            take(settings, state, filters[hypothesis])
    before = np.empty(3)
    for number in range(3):
        before[number] = expected_reading(state.mean, number)
    settle(settings, state, filters, moves)
    for number in range(3):
        state.late[number] -= expected_reading(state.mean, number) - before[number]
    begin(state)


@compiled
def go(settings: FilterSettings, state: FilterState, counts: IntArray, present: NDArray[np.bool_]) -> int:
    """Take one sample in place, but for the open filters; return what they have to do now.

    The trucks move only where all four wheels were read.

    Args:
        settings: Settings of the filter.
        state: Estimate before the sample; changed to the estimate after it.
        counts: Counts in the order of `CHANNELS`, shape `(7,)`.
        present: Whether each count was read, shape `(7,)`.

    Returns:
        `NOTHING`, `PLACE` or `CLOSE`.
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
        watch(settings, state)
    return CLOSE if has_ended(state) else NOTHING


@compiled
def follow(settings: FilterSettings, state: FilterState, filters: Record, todo: int, moves: Array) -> None:
    """Let the open filters do what `go` has returned; `moves` as in `close`."""
    if todo == PLACE:
        place(settings, state, filters)
    elif todo == CLOSE:
        close(settings, state, filters, moves)


@compiled
def advance(
    settings: FilterSettings,
    state: FilterState,
    filters: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    moves: Array,
) -> None:
    """Take one sample in place.

    Args:
        settings: Settings of the filter.
        state: Estimate before the sample; changed to the estimate after it.
        filters: Open filters, changed as well, `(H,)` records of `OpenFilter`.
        counts: Counts in the order of `CHANNELS`, shape `(7,)`.
        present: Whether each count was read, shape `(7,)`.
        moves: Way to what is believed after each step, `(D, 20)`, see `settle`.
    """
    follow(settings, state, filters, go(settings, state, counts, present), moves)


@compiled
def finish(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """End the step that is under way, if the robot has moved in it; `moves` as in `close`."""
    if state.rolled.sum() > 0.0:
        close(settings, state, filters, moves)


@compiled
def go_live(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> int:
    """Take one sample `(7,)` of a live stream, in place, as `go`; both are records `(1,)`."""
    return go(settings[0], states[0], counts, present)


@compiled
def follow_live(settings: Record, states: Record, filters: Record, todo: int) -> None:
    """Let the open filters do what `go_live` has returned, in place."""
    follow(settings[0], states[0], filters, todo, np.empty((0, STATES + 1)))
