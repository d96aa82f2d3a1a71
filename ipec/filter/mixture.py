"""The estimate: the mixture of the open filters of all hypotheses; compiled.

The slow states of an open filter have a nearly flat prior, so that they represent the likelihood alone. The
estimate adds a spike-and-slab prior: a suspect is absent, or present with a size of up to
`prior.SUSPECT_SIZES`. Suspects are added one by one while they increase the evidence (Tipping & Faul, Fast
marginal likelihood maximisation for sparse Bayesian models, AISTATS 2003), and the estimates with fewer and
more suspects are averaged by their probability.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.poses import add_axle_angle_variance
from omnimate.ipec.filter.records import (
    FAST,
    HYPOTHESIS_COUNT,
    JOINT_BIAS,
    POSE,
    SIDES,
    SLOW,
    STATES,
    SUSPECT_COUNT,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, Record, compiled
from omnimate.vehicle.matrices import invert, multiply, quadratic_form

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_SUSPECTS = 2  # at once; assumption: three wrong values are less probable than physics not modelled here
SIZES_PER_SUSPECT = 3  # equally probable standard deviations of a suspect, each a third of the previous one
TURNED_AXLE_PROBABILITY = (
    0.5  # that an apparent joint bias is an axle turned in its truck: both are as likely
)
# Log odds of a change of hypothesis in one step of 50 mm; assumption: a joint comes loose once in 50 km.
MIN_LOG_ODDS = -math.log(1e6)
MIN_RELATIVE_WEIGHT = 0.03  # less probable hypotheses, relative to the best one, are left out to save time
MIN_SUSPECT_LOG_ODDS = -3.0  # suspects below are not added: they would get less than 5 % of the weight


@compiled
def suspect_odds(
    settings: FilterSettings, number: int, sparsity: float, quality: float
) -> tuple[float, float]:
    """Return the log odds that a suspect is present, and its most probable variance.

    `sparsity` and `quality` are s and q of Tipping & Faul (2003), section 3.
    """
    best, likely, total = -1e300, 0.0, 0.0
    for scale in range(SIZES_PER_SUSPECT):
        variance = (settings.size[number] / 3.0**scale) ** 2
        gain = variance * sparsity
        score = 0.5 * (variance * quality * quality / (1.0 + gain) - math.log1p(gain))
        if score > best:
            total *= math.exp(best - score)
            best, likely = score, variance
        total += math.exp(score - best) / SIZES_PER_SUSPECT
    return settings.odds[number] + best + math.log(total), likely


@compiled
def most_probable_suspect(
    settings: FilterSettings, prior: Array, spread: Array, mean: Array, admitted: NDArray[np.bool_]
) -> tuple[int, float, float]:
    """Return the most probable suspect that is not admitted (or -1), its log odds and its variance.

    `prior` is the inverse covariance of the slow states with the suspects that are `admitted` `(15,)`;
    `spread` `(11, 11)` and `mean` `(11,)` are their posterior covariance and mean.
    """
    candidate, best, variance = -1, MIN_SUSPECT_LOG_ODDS, 0.0
    product = np.empty(SLOW)
    for number in range(SUSPECT_COUNT):
        if admitted[number]:
            continue
        direction = settings.suspect[number]
        multiply(product, prior, direction)
        sparsity, quality = 0.0, 0.0
        for row in range(SLOW):
            sparsity += direction[row] * product[row]
            quality += product[row] * mean[row]
        odds, likely = suspect_odds(settings, number, sparsity - quadratic_form(spread, product), quality)
        if odds > best:
            candidate, best, variance = number, odds, likely
    return candidate, best, variance


@compiled
def admit_suspect(prior: Array, spread: Array, direction: Array, variance: float) -> None:
    """Add a suspect to prior information and posterior covariance `(11, 11)`, in place."""
    product, carried = np.empty(SLOW), np.empty(SLOW)
    multiply(product, prior, direction)
    multiply(carried, spread, product)
    prior_curvature = posterior_curvature = 0.0
    for row in range(SLOW):
        prior_curvature += direction[row] * product[row]
        posterior_curvature += product[row] * carried[row]
    weight = variance / (1.0 + variance * prior_curvature)
    more = weight / (1.0 - weight * posterior_curvature)
    prior -= np.outer(weight * product, product)
    spread += np.outer(more * carried, carried)


@compiled
def discard_common_scale(information: Array, pull: Array, variance: float) -> None:
    """Remove the information on the common scale of all wheels from a likelihood, in place.

    At the start and end of a bend the joints show that scale, but a late reading and a compliant drive look
    the same there; only absolute poses can separate them.

    Args:
        information: Inverse covariance of the slow states by the readings, shape `(11, 11)`.
        pull: Product of `information` and their mean, shape `(11,)`.
        variance: Variance of the apparent error of that scale.
    """
    product = information[:, 0] + information[:, 1] + information[:, 2] + information[:, 3]
    total = 1.0 / variance + product[0] + product[1] + product[2] + product[3]
    pull -= product * (pull[0] + pull[1] + pull[2] + pull[3]) / total
    information -= np.outer(product, product) / total


@compiled
def average_slow_states(
    settings: FilterSettings, state: FilterState, opened: OpenFilter
) -> tuple[Array, Array, Array, Array]:
    """Return the posterior of the slow states from an open filter and the prior.

    Returns:
        The inverse covariance of the open filter's slow states `(11, 11)`, their mean `(11,)` and covariance
        `(11, 11)` with the prior, and the probabilities of the suspects `(15,)`.
    """
    information = opened.covariance[FAST:, FAST:].copy()
    invert(information)
    now, pull = settings.independent_share * information, np.empty(SLOW)
    multiply(pull, now, state.mean[FAST:] + opened.offset[FAST:])
    for row in range(SLOW):
        now[row, row] -= settings.independent_share / settings.open_variance[row]
    if not state.has_fix:
        discard_common_scale(now, pull, settings.open_variance[0])
    prior = settings.nominal_information.copy()
    now += prior
    invert(now)
    guess, admitted, suspicion = np.empty(SLOW), np.zeros(SUSPECT_COUNT, np.bool_), np.zeros(SUSPECT_COUNT)
    multiply(guess, now, pull)
    mean, spread = guess.copy(), now.copy()
    total, score = 1.0, 0.0
    for _ in range(MAX_SUSPECTS):
        candidate, odds, variance = most_probable_suspect(settings, prior, now, guess, admitted)
        if candidate < 0:
            break
        admit_suspect(prior, now, settings.suspect[candidate], variance)
        multiply(guess, now, pull)
        admitted[candidate] = True
        score += odds
        weight = math.exp(min(score, 300.0))
        share = weight / (total + weight)
        difference = guess - mean
        spread += share * (now - spread + (1.0 - share) * np.outer(difference, difference))
        mean += share * difference
        total += weight
        for number in range(SUSPECT_COUNT):
            if admitted[number]:
                suspicion[number] *= 1.0 - share
                suspicion[number] += share
    return information, mean, spread, suspicion


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
    """Move the estimate to the mixture; in a replay, to the mixture of the first run.

    Args:
        settings: Settings of the filter.
        state: Estimate, changed in place.
        filters: Open filters, changed in place.
        moves: Differences of mixture and estimate, and whether the next step is short, `(D, 20)`; read in a
            replay, filled otherwise. With `(0, 20)` nothing is stored.
    """
    if state.is_replay:
        state.move[:] = moves[state.mixture_count, :STATES]
        state.is_disturbed = int(moves[state.mixture_count, STATES])
    else:
        mix_hypotheses(settings, state, filters)
        state.is_disturbed = 1 if filters[state.weight.argmax()].alert[:SIDES].max() > 0.0 else 0
        if state.mixture_count < len(moves):
            moves[state.mixture_count, :STATES] = state.move
            moves[state.mixture_count, STATES] = state.is_disturbed
    state.mixture_count += 1
    state.mean[:] += state.move
    for hypothesis in range(HYPOTHESIS_COUNT):
        if filters[hypothesis].is_active:
            filters[hypothesis].offset[:] -= state.move
    state.shift[:] += state.move[:POSE]
    if not state.is_replay:
        bias = state.mean[JOINT_BIAS]
        state.axle_variance = 0.0 if state.has_fix else TURNED_AXLE_PROBABILITY * bias * bias
        add_axle_angle_variance(state.covariance, state.mean, state.origin, state.axle_variance)


@compiled
def mix_hypotheses(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Fill mixture minus estimate, the mixture's covariance and the suspects' probabilities."""
    weigh_hypotheses(settings, state)
    moves = np.zeros((HYPOTHESIS_COUNT, STATES))
    state.suspicion[:] = 0.0
    state.move[:] = 0.0
    state.covariance[:] = 0.0
    for hypothesis in range(HYPOTHESIS_COUNT):
        weight = state.weight[hypothesis]
        if weight > 0.0:
            suspicion = add_hypothesis(settings, state, filters[hypothesis], moves[hypothesis])
            state.move[:] += weight * moves[hypothesis]
            state.suspicion[:] += weight * suspicion
    for hypothesis in range(HYPOTHESIS_COUNT):
        if 0.0 < state.weight[hypothesis] < 1.0:
            difference = moves[hypothesis] - state.move
            state.covariance[:] += state.weight[hypothesis] * np.outer(difference, difference)


@compiled
def add_hypothesis(settings: FilterSettings, state: FilterState, opened: OpenFilter, move: Array) -> Array:
    """Fill the move `(19,)` to the estimate under one hypothesis; return the suspects' probabilities `(15,)`.

    Its covariance is added to `state.covariance`, weighted by the hypothesis' probability.
    """
    covariance, known, weight = opened.covariance, state.covariance, state.weight[opened.number]
    information, mean, spread, suspicion = average_slow_states(settings, state, opened)
    gains, crosses = np.empty((FAST, SLOW)), np.empty((FAST, SLOW))  # of the fast states by the slow ones
    for row in range(FAST):
        multiply(gains[row], information, covariance[row, FAST:])
        multiply(crosses[row], spread, gains[row])
    move[FAST:] = mean - state.mean[FAST:]
    for row in range(POSE):
        move[row] = opened.offset[row]
        for column in range(SLOW):
            move[row] += gains[row, column] * (move[FAST + column] - opened.offset[FAST + column])
    known[FAST:, FAST:] += weight * spread
    known[:FAST, FAST:] += weight * crosses
    known[FAST:, :FAST] += weight * crosses.T
    for row in range(FAST):
        for column in range(row + 1):
            rest = covariance[row, column]
            for middle in range(SLOW):
                rest -= gains[row, middle] * covariance[column, FAST + middle]
                rest += crosses[row, middle] * gains[column, middle]
            known[row, column] += weight * rest
            if column < row:
                known[column, row] += weight * rest
    return suspicion
