"""The estimate, as a mixture of what the open filters give under each hypothesis; compiled.

The open filter excludes nothing: its slow states begin as uncertain as nothing is known of them. What it has
learned of them is a likelihood. The estimate puts a prior to it that expects few things to be wrong: a
suspect is either not at work, or it is, with a size that may be anything up to what `prior.SIZES` says.
Suspects are admitted one after the other where they make the readings more probable (Tipping & Faul, Fast
marginal likelihood maximisation for sparse Bayesian models, AISTATS 2003), and the estimates with one
suspect fewer or more are averaged by their probability.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.poses import turn
from omnimate.ipec.filter.records import (
    BANK,
    FAST,
    JOINT_BIAS,
    POSE,
    SIDES,
    SLOW,
    STATES,
    SUSPECTS,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, Record, compiled
from omnimate.vehicle.matrices import invert, multiply, quadratic_form

if TYPE_CHECKING:
    from numpy.typing import NDArray

# More things wrong at once than that are less probable than physics that the model does not have.
ADMITTED = 2
SCALES = 3  # sizes of a suspect, each a third of the one before, that are as probable as each other
TURNED = 0.5  # probability that what looks like a joint's bias is an axle that is turned in its truck
CHANGE = -math.log(1e6)  # odds of a change in a step: a joint comes loose once in 50 km
NEGLIGIBLE = 0.03  # of the most probable hypothesis, below which another one does not count
HOPELESS = -3.0  # logarithm of the odds below which a suspect is not examined


@compiled
def suspect_odds(
    settings: FilterSettings, number: int, sparsity: float, quality: float
) -> tuple[float, float]:
    """Return the logarithm of the odds that a suspect is at work, and its most probable variance.

    `sparsity` is the information about its size that the estimate without it leaves, s of Tipping & Faul;
    `quality` is the pull of the readings towards it, their q.
    """
    best, likely, total = -1e300, 0.0, 0.0
    for scale in range(SCALES):
        variance = (settings.size[number] / 3.0**scale) ** 2
        gain = variance * sparsity
        score = 0.5 * (variance * quality * quality / (1.0 + gain) - math.log1p(gain))
        if score > best:
            total *= math.exp(best - score)
            best, likely = score, variance
        total += math.exp(score - best) / SCALES
    return settings.odds[number] + best + math.log(total), likely


@compiled
def find_suspect(
    settings: FilterSettings, prior: Array, spread: Array, mean: Array, admitted: NDArray[np.bool_]
) -> tuple[int, float, float]:
    """Return the most probable suspect that is not admitted (or -1), the logarithm of its odds, its variance.

    `prior` is the inverse covariance of the slow states with the suspects that are `admitted` `(15,)`;
    `spread` `(11, 11)` and `mean` `(11,)` are their covariance and mean after the readings.
    """
    found, best, variance = -1, HOPELESS, 0.0
    drawn = np.empty(SLOW)
    for number in range(SUSPECTS):
        if admitted[number]:
            continue
        direction = settings.suspect[number]
        multiply(drawn, prior, direction)
        sparsity, quality = 0.0, 0.0
        for row in range(SLOW):
            sparsity += direction[row] * drawn[row]
            quality += drawn[row] * mean[row]
        odds, likely = suspect_odds(settings, number, sparsity - quadratic_form(spread, drawn), quality)
        if odds > best:
            found, best, variance = number, odds, likely
    return found, best, variance


@compiled
def admit(prior: Array, spread: Array, direction: Array, variance: float) -> None:
    """Widen prior and spread `(11, 11)` by a suspect along its direction `(11,)`, in place."""
    drawn, carried = np.empty(SLOW), np.empty(SLOW)
    multiply(drawn, prior, direction)
    multiply(carried, spread, drawn)
    own = other = 0.0
    for row in range(SLOW):
        own += direction[row] * drawn[row]
        other += drawn[row] * carried[row]
    weight = variance / (1.0 + variance * own)
    more = weight / (1.0 - weight * other)
    prior -= np.outer(weight * drawn, drawn)
    spread += np.outer(more * carried, carried)


@compiled
def forget_scale(information: Array, pull: Array, variance: float) -> None:
    """Remove what the readings say of the size of all wheels at once, in place.

    Joints that turn while a bend begins or ends show that size, against a turn of a known angle. So do a
    reading that is late and a drive that gives way, and poses alone tell them apart.

    Args:
        information: Inverse covariance of the slow states by the readings, shape `(11, 11)`.
        pull: Product of `information` and their mean, shape `(11,)`.
        variance: Variance of what that size may seem to be wrong by.
    """
    drawn = information[:, 0] + information[:, 1] + information[:, 2] + information[:, 3]
    total = 1.0 / variance + drawn[0] + drawn[1] + drawn[2] + drawn[3]
    pull -= drawn * (pull[0] + pull[1] + pull[2] + pull[3]) / total
    information -= np.outer(drawn, drawn) / total


@compiled
def average_slow_states(
    settings: FilterSettings, state: FilterState, opened: OpenFilter
) -> tuple[Array, Array, Array, Array]:
    """Return what an open filter and the prior together say of the slow states.

    Returns:
        The inverse covariance of the open filter's slow states `(11, 11)`, their mean `(11,)` and covariance
        `(11, 11)` with the prior, and the probability that each suspect is at work `(15,)`.
    """
    seen = opened.covariance[FAST:, FAST:].copy()
    invert(seen)
    now, pull = settings.independent * seen, np.empty(SLOW)
    multiply(pull, now, state.mean[FAST:] + opened.offset[FAST:])
    for row in range(SLOW):
        now[row, row] -= settings.independent / settings.open[row]
    if not state.fixed:
        forget_scale(now, pull, settings.open[0])
    prior = settings.usual.copy()
    now += prior
    invert(now)
    guess, admitted, suspicion = np.empty(SLOW), np.zeros(SUSPECTS, np.bool_), np.zeros(SUSPECTS)
    multiply(guess, now, pull)
    mean, spread = guess.copy(), now.copy()
    total, score = 1.0, 0.0
    for _ in range(ADMITTED):
        found, odds, variance = find_suspect(settings, prior, now, guess, admitted)
        if found < 0:
            break
        admit(prior, now, settings.suspect[found], variance)
        multiply(guess, now, pull)
        admitted[found] = True
        score += odds
        weight = math.exp(min(score, 300.0))
        share = weight / (total + weight)
        apart = guess - mean
        spread += share * (now - spread + (1.0 - share) * np.outer(apart, apart))
        mean += share * apart
        total += weight
        for number in range(SUSPECTS):
            if admitted[number]:
                suspicion[number] *= 1.0 - share
                suspicion[number] += share
    return seen, mean, spread, suspicion


@compiled
def weigh_hypotheses(settings: FilterSettings, state: FilterState) -> None:
    """Fill the probabilities of the hypotheses; those below `NEGLIGIBLE` are left out."""
    scores = settings.credit + state.score
    most, total = scores.max(), 0.0
    for hypothesis in range(BANK):
        behind = scores[hypothesis] - most
        if behind < CHANGE:  # however long all was well, it may have changed since
            state.score[hypothesis] += CHANGE - behind
        state.weight[hypothesis] = math.exp(scores[hypothesis] - most)
        if state.weight[hypothesis] < NEGLIGIBLE:
            state.weight[hypothesis] = 0.0
        total += state.weight[hypothesis]
    state.weight[:] /= total


@compiled
def move_to_mixture(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """Move the estimate to the mixture of now, or to that of before where a part of a drive runs again.

    Args:
        settings: Settings of the filter.
        state: Estimate, changed in place.
        filters: Open filters, changed in place.
        moves: From the estimate to the mixture, each time that it is mixed, and whether the next step is
            short, `(D, 20)`; read where a part of a drive runs again, else filled. With `(0, 20)` nothing is
            kept.
    """
    if state.repeated:
        state.move[:] = moves[state.decided, :STATES]
        state.bumpy = int(moves[state.decided, STATES])
    else:
        mix(settings, state, filters)
        state.bumpy = 1 if filters[state.weight.argmax()].alert[:SIDES].max() > 0.0 else 0
        if state.decided < len(moves):
            moves[state.decided, :STATES] = state.move
            moves[state.decided, STATES] = state.bumpy
    state.decided += 1
    state.mean[:] += state.move
    for hypothesis in range(BANK):
        if filters[hypothesis].followed:
            filters[hypothesis].offset[:] -= state.move
    state.shift[:] += state.move[:POSE]
    if not state.repeated:
        bias = state.mean[JOINT_BIAS]
        state.turned = 0.0 if state.fixed else TURNED * bias * bias
        turn(state.known, state.mean, state.origin, state.turned)


@compiled
def mix(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Fill the step from the estimate to the mixture, the mixture's covariance and the suspicions."""
    weigh_hypotheses(settings, state)
    moves = np.zeros((BANK, STATES))
    state.suspicion[:] = 0.0
    state.move[:] = 0.0
    state.known[:] = 0.0
    for hypothesis in range(BANK):
        weight = state.weight[hypothesis]
        if weight > 0.0:
            suspicion = add_hypothesis(settings, state, filters[hypothesis], moves[hypothesis])
            state.move[:] += weight * moves[hypothesis]
            state.suspicion[:] += weight * suspicion
    for hypothesis in range(BANK):
        if 0.0 < state.weight[hypothesis] < 1.0:
            apart = moves[hypothesis] - state.move
            state.known[:] += state.weight[hypothesis] * np.outer(apart, apart)


@compiled
def add_hypothesis(settings: FilterSettings, state: FilterState, opened: OpenFilter, move: Array) -> Array:
    """Fill the step `(19,)` from the estimate to that under one hypothesis; return its suspicions `(15,)`.

    Its covariance is added to `state.known` with the hypothesis' weight.
    """
    covariance, known, weight = opened.covariance, state.known, state.weight[opened.number]
    seen, mean, spread, suspicion = average_slow_states(settings, state, opened)
    gains, crosses = np.empty((FAST, SLOW)), np.empty((FAST, SLOW))  # of the fast states by the slow ones
    for row in range(FAST):
        multiply(gains[row], seen, covariance[row, FAST:])
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
