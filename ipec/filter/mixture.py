"""The estimate: the mixture of the open filters of all hypotheses; compiled."""

from __future__ import annotations

import math

import numpy as np

from omnimate.ipec.filter.poses import add_axle_angle_variance, add_nonlinear_error
from omnimate.ipec.filter.records import (
    FAST,
    HYPOTHESIS_COUNT,
    JOINT_BIAS,
    LINK,
    POSE,
    SIDES,
    SLOW,
    STATES,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.ipec.filter.suspects import average_slow_states
from omnimate.vehicle.compiled import Array, Record, compiled
from omnimate.vehicle.matrices import add_outer, add_scaled, multiply

TURNED_AXLE_PROBABILITY = 0.5  # that an apparent joint bias is a turned axle: both are as likely
# Log odds of a change of hypothesis in one step of 50 mm; assumption: a joint comes loose once in 50 km.
MIN_LOG_ODDS = -math.log(1e6)
MIN_RELATIVE_WEIGHT = 0.03  # less probable hypotheses, relative to the best one, are left out to save time


@compiled
def weigh_hypotheses(settings: FilterSettings, state: FilterState) -> None:
    """Fill the probabilities of the hypotheses; those below `MIN_RELATIVE_WEIGHT` become 0."""
    scores = settings.log_prior + state.score
    most, total = scores.max(), 0.0
    for hypothesis in range(HYPOTHESIS_COUNT):
        behind = scores[hypothesis] - most
        if behind < MIN_LOG_ODDS:  # a floor for all hypotheses: an error may begin at any time
            state.score[hypothesis] += MIN_LOG_ODDS - behind
        state.weight[hypothesis] = math.exp(scores[hypothesis] - most)
        if state.weight[hypothesis] < MIN_RELATIVE_WEIGHT:
            state.weight[hypothesis] = 0.0
        total += state.weight[hypothesis]
    state.weight[:] /= total


@compiled
def move_to_mixture(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """Move estimate and open filters to the mixture, in place; in a replay, to the mixture of the first run.

    `moves` `(D, 21)` are differences of mixture and estimate, whether the next step is short, and the
    nonlinear error: read in a replay, filled otherwise. With `(0, 21)` nothing is stored.
    """
    if state.is_replay:
        state.move[:] = moves[state.mixture_count, :STATES]
        state.is_disturbed = int(moves[state.mixture_count, STATES])
        state.nonlinear_error = moves[state.mixture_count, STATES + 1]
    else:
        mix_hypotheses(settings, state, filters)
        state.is_disturbed = 1 if filters[state.weight.argmax()].alert[:SIDES].max() > 0.0 else 0
        # The path was integrated with headings that are off by their standard deviation: half of its square.
        distance = 0.25 * state.step_distance.sum()
        state.nonlinear_error += 0.5 * distance * state.covariance[LINK, LINK]
        if state.fix_count > 0:
            state.nonlinear_error = 0.0
        if state.mixture_count < len(moves):
            moves[state.mixture_count, :STATES] = state.move
            moves[state.mixture_count, STATES] = state.is_disturbed
            moves[state.mixture_count, STATES + 1] = state.nonlinear_error
    state.mixture_count += 1
    add_scaled(state.mean, 1.0, state.move)
    for hypothesis in range(HYPOTHESIS_COUNT):
        if filters[hypothesis].is_active:
            add_scaled(filters[hypothesis].offset, -1.0, state.move)
    add_scaled(state.shift, 1.0, state.move[:POSE])
    if not state.is_replay:
        bias = state.mean[JOINT_BIAS]
        state.axle_variance = 0.0 if state.fix_count else TURNED_AXLE_PROBABILITY * bias * bias
        add_axle_angle_variance(state.covariance, state.mean, state.origin, state.axle_variance)
        add_nonlinear_error(state.covariance, state.nonlinear_error)


@compiled
def mix_hypotheses(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Fill mixture minus estimate, the mixture's covariance, and which values are wrong."""
    weigh_hypotheses(settings, state)
    moves = np.zeros((HYPOTHESIS_COUNT, STATES))
    state.suspicion[:] = 0.0
    state.move[:] = 0.0
    state.covariance[:] = 0.0
    for hypothesis in range(HYPOTHESIS_COUNT):
        weight = state.weight[hypothesis]
        if weight > 0.0:
            suspicion = add_hypothesis(settings, state, filters[hypothesis], moves[hypothesis])
            add_scaled(state.move, weight, moves[hypothesis])
            add_scaled(state.suspicion, weight, suspicion)
    for hypothesis in range(HYPOTHESIS_COUNT):
        if 0.0 < state.weight[hypothesis] < 1.0:
            add_scaled(moves[hypothesis], -1.0, state.move)
            add_outer(state.covariance, state.weight[hypothesis], moves[hypothesis])


@compiled
def add_hypothesis(settings: FilterSettings, state: FilterState, opened: OpenFilter, move: Array) -> Array:
    """Fill the move `(19,)` to the estimate under one hypothesis; return what is wrong as `suspicion` `(9,)`.

    Its covariance is added to `state.covariance`, weighted by the hypothesis' probability.
    """
    covariance, known, weight = opened.covariance, state.covariance, state.weight[opened.number]
    information, mean, spread, suspicion = average_slow_states(settings, state, opened)
    gains, crosses = np.empty((FAST, SLOW)), np.empty((FAST, SLOW))  # of the fast states by the slow ones
    for row in range(FAST):
        multiply(gains[row], information, covariance[row, FAST:])
        multiply(crosses[row], spread, gains[row])
    move[FAST:] = mean
    add_scaled(move[FAST:], -1.0, state.mean[FAST:])
    for row in range(POSE):
        move[row] = opened.offset[row]
        for column in range(SLOW):
            move[row] += gains[row, column] * (move[FAST + column] - opened.offset[FAST + column])
    for row in range(SLOW):
        add_scaled(known[FAST + row, FAST:], weight, spread[row])
    for row in range(FAST):
        for column in range(SLOW):
            known[row, FAST + column] += weight * crosses[row, column]
            known[FAST + column, row] = known[row, FAST + column]
        for column in range(row + 1):
            rest = covariance[row, column]
            for middle in range(SLOW):
                rest -= gains[row, middle] * covariance[column, FAST + middle]
                rest += crosses[row, middle] * gains[column, middle]
            known[row, column] += weight * rest
            if column < row:
                known[column, row] += weight * rest
    return suspicion
