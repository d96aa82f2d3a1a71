"""What is believed of a robot, given what the open filter has seen; compiled.

The open filter excludes nothing: its slow states begin as uncertain as nothing is known of them. What it has
learned of them is a likelihood. The estimate puts a prior to it that expects few things to be wrong: a
suspect is either not at work, or it is, with a size that may be anything up to what `prior.SIZES` says.
Suspects are admitted one after the other where they make the readings more probable (Tipping & Faul, Fast
marginal likelihood maximisation for sparse Bayesian models, AISTATS 2003), and the estimates with one
suspect fewer or more are averaged by their probability.
"""

from __future__ import annotations

import math

import numpy as np

from omnimate.ipec.filter.poses import turn
from omnimate.ipec.filter.records import (
    BELIEFS,
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

# More things wrong at once than that are less probable than physics that the model does not have.
ADMITTED = 2
SCALES = 3  # sizes of a suspect, each a third of the one before, that are as probable as each other
TURNED = 0.5  # probability that what looks like a joint's bias is an axle that is turned in its truck
CHANGE = -math.log(1e6)  # odds of a change in a step: a joint comes loose once in 50 km
NEGLIGIBLE = 0.03  # of the most probable hypothesis, below which another one does not count
HOPELESS = -3.0  # logarithm of the odds below which a suspect is not looked at


@compiled
def chances(settings: FilterSettings, number: int, sparsity: float, quality: float) -> tuple[float, float]:
    """Return the logarithm of the odds that a suspect is at work, and its most probable variance.

    Args:
        settings: Settings of the filter.
        number: Number of the suspect.
        sparsity: Information about its size that the estimate without it leaves, s of Tipping & Faul.
        quality: Pull of what was seen towards it, their q.
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
def choose(
    settings: FilterSettings, prior: Array, spread: Array, mean: Array, admitted: Array
) -> tuple[int, float, float]:
    """Return the most probable suspect that is not admitted (or -1), the logarithm of its odds, its variance.

    Args:
        settings: Settings of the filter.
        prior: Inverse covariance of the slow states with what is admitted, shape `(11, 11)`.
        spread: Their covariance after what was seen, shape `(11, 11)`.
        mean: Their mean after what was seen, shape `(11,)`.
        admitted: Place in which each suspect was admitted; 0 for one that was not, shape `(15,)`.
    """
    chosen, best, variance = -1, HOPELESS, 0.0
    drawn = np.empty(SLOW)
    for number in range(SUSPECTS):
        if admitted[number] > 0.0:
            continue
        direction = settings.suspect[number]
        multiply(drawn, prior, direction)
        sparsity, quality = 0.0, 0.0
        for row in range(SLOW):
            sparsity += direction[row] * drawn[row]
            quality += drawn[row] * mean[row]
        odds, likely = chances(settings, number, sparsity - quadratic_form(spread, drawn), quality)
        if odds > best:
            chosen, best, variance = number, odds, likely
    return chosen, best, variance


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
    for row in range(SLOW):
        for column in range(SLOW):
            prior[row, column] -= weight * drawn[row] * drawn[column]
            spread[row, column] += more * carried[row] * carried[column]


@compiled
def forget_scale(told: Array, pull: Array, variance: float) -> None:
    """Take out of what was learned what it says of the size of all wheels at once, in place.

    Joints that turn while a bend begins or ends show that size, against a turn of a known angle. So do a
    reading that is late and a drive that gives way, and poses alone tell them apart.

    Args:
        told: What the readings say of the slow states: inverse covariance, shape `(11, 11)`.
        pull: Product of `told` and their mean, shape `(11,)`.
        variance: Variance of what that size may seem to be wrong by.
    """
    drawn = np.zeros(SLOW)
    total, along = 1.0 / variance, 0.0
    for wheel in range(4):
        along += pull[wheel]
        for row in range(SLOW):
            drawn[row] += told[row, wheel]
    for wheel in range(4):
        total += drawn[wheel]
    for row in range(SLOW):
        pull[row] -= drawn[row] * along / total
        for column in range(SLOW):
            told[row, column] -= drawn[row] * drawn[column] / total


@compiled
def learn(
    settings: FilterSettings, state: FilterState, opened: OpenFilter, seen: Array, told: Array, pull: Array
) -> None:
    """Fill what the readings say of the slow states.

    Args:
        settings: Settings of the filter.
        state: Estimate.
        opened: Open filter of the hypothesis.
        seen: Inverse covariance of the slow states of its open filter, shape `(11, 11)`.
        told: Filled with their inverse covariance by the readings alone, shape `(11, 11)`.
        pull: Filled with the product of `told` and their mean, shape `(11,)`.
    """
    pull[:] = 0.0
    for row in range(SLOW):
        for column in range(SLOW):
            mean = state.mean[FAST + column] + opened.offset[FAST + column]
            pull[row] += settings.independent * seen[row, column] * mean
            told[row, column] = settings.independent * seen[row, column]
        told[row, row] -= settings.independent / settings.open[row]
    if not state.fixed:
        forget_scale(told, pull, settings.open[0])


@compiled
def average(
    settings: FilterSettings,
    state: FilterState,
    opened: OpenFilter,
    seen: Array,
    mean: Array,
    spread: Array,
    suspicion: Array,
) -> None:
    """Fill mean `(11,)` and covariance `(11, 11)` of the slow states, and the suspicions.

    Args:
        settings: Settings of the filter.
        state: Estimate.
        opened: Open filter of the hypothesis.
        seen: Inverse covariance of the slow states of its open filter, shape `(11, 11)`.
        mean: Filled.
        spread: Filled.
        suspicion: Filled with the probability that each suspect is at work, shape `(15,)`.
    """
    suspicion[:] = 0.0
    pull, guess = np.zeros(SLOW), np.empty(SLOW)
    prior, now = np.empty((SLOW, SLOW)), np.empty((SLOW, SLOW))
    learn(settings, state, opened, seen, now, pull)
    prior[:] = settings.usual
    for row in range(SLOW):
        for column in range(SLOW):
            now[row, column] += prior[row, column]
    invert(now)
    multiply(guess, now, pull)
    admitted = np.zeros(SUSPECTS)
    mean[:] = guess
    spread[:] = now
    total, score = 1.0, 0.0
    for place in range(1, ADMITTED + 1):
        chosen, odds, variance = choose(settings, prior, now, guess, admitted)
        if chosen < 0:
            break
        admit(prior, now, settings.suspect[chosen], variance)
        multiply(guess, now, pull)
        admitted[chosen] = place
        score += odds
        weight = math.exp(min(score, 300.0))
        share = weight / (total + weight)
        blend(mean, spread, guess, now, share)
        total += weight
        for number in range(SUSPECTS):
            if admitted[number] > 0.0:
                suspicion[number] *= 1.0 - share
                suspicion[number] += share
    for number in range(SUSPECTS):
        if admitted[number] == 0.0:
            suspicion[number] = 0.0


@compiled
def blend(mean: Array, spread: Array, guess: Array, now: Array, share: float) -> None:
    """Add a share of another distribution to a mean `(11,)` and a covariance `(11, 11)`, in place."""
    for row in range(SLOW):
        for column in range(SLOW):
            apart = (guess[row] - mean[row]) * (guess[column] - mean[column])
            spread[row, column] += share * (now[row, column] - spread[row, column] + (1.0 - share) * apart)
    for row in range(SLOW):
        mean[row] += share * (guess[row] - mean[row])


@compiled
def weigh(settings: FilterSettings, state: FilterState) -> None:
    """Fill the probabilities of the hypotheses; those below `NEGLIGIBLE` are left out."""
    scores = settings.credit + state.score
    most, total = scores.max(), 0.0
    for hypothesis in range(BELIEFS):
        behind = scores[hypothesis] - most
        if behind < CHANGE:  # however long all was well, it may have changed since
            state.score[hypothesis] += CHANGE - behind
        state.weight[hypothesis] = math.exp(scores[hypothesis] - most)
        if state.weight[hypothesis] < NEGLIGIBLE:
            state.weight[hypothesis] = 0.0
        total += state.weight[hypothesis]
    state.weight[:] /= total


@compiled
def settle(settings: FilterSettings, state: FilterState, filters: Record, moves: Array) -> None:
    """Move the estimate to what is believed now, or was believed when a part of a drive ran before.

    Args:
        settings: Settings of the filter.
        state: Estimate, changed in place.
        filters: Open filters, changed in place.
        moves: Way to what is believed, each time that it is decided, and whether the next step is short,
            `(D, 20)`; read where a part of a drive runs again, else filled. With `(0, 20)` nothing is kept.
    """
    if state.repeated:
        state.move[:] = moves[state.decided, :STATES]
        state.bumpy = int(moves[state.decided, STATES])
    else:
        believe(settings, state, filters)
        state.bumpy = 1 if filters[state.weight.argmax()].alert[:SIDES].max() > 0.0 else 0
        if state.decided < len(moves):
            moves[state.decided, :STATES] = state.move
            moves[state.decided, STATES] = state.bumpy
    state.decided += 1
    for row in range(STATES):
        state.mean[row] += state.move[row]
    for hypothesis in range(BELIEFS):
        opened = filters[hypothesis]
        if opened.followed:
            for row in range(STATES):
                opened.offset[row] -= state.move[row]
    for row in range(POSE):
        state.shift[row] += state.move[row]
    if not state.repeated:
        bias = state.mean[JOINT_BIAS]
        state.turned = 0.0 if state.fixed else TURNED * bias * bias
        turn(state.known, state.mean, state.origin, state.turned)


@compiled
def believe(settings: FilterSettings, state: FilterState, filters: Record) -> None:
    """Fill the way to what is believed now, its covariance and the suspicions."""
    weigh(settings, state)
    state.suspicion[:] = 0.0
    moves, move, suspicion = np.zeros((BELIEFS, STATES)), state.move, np.empty(SUSPECTS)
    known = state.known
    move[:] = 0.0
    known[:] = 0.0
    for hypothesis in range(BELIEFS):
        weight = state.weight[hypothesis]
        if weight == 0.0:
            continue
        believe_under(settings, state, filters[hypothesis], moves[hypothesis], known, suspicion)
        move += weight * moves[hypothesis]
        state.suspicion[:] += weight * suspicion
    for hypothesis in range(BELIEFS):
        if 0.0 < state.weight[hypothesis] < 1.0:
            moves[hypothesis] -= move
            known += state.weight[hypothesis] * np.outer(moves[hypothesis], moves[hypothesis])


@compiled
def believe_under(
    settings: FilterSettings,
    state: FilterState,
    opened: OpenFilter,
    move: Array,
    known: Array,
    suspicion: Array,
) -> None:
    """Fill what is believed under one hypothesis.

    Args:
        settings: Settings of the filter.
        state: Estimate.
        opened: Open filter of the hypothesis.
        move: Filled with the way from the estimate to what is believed, shape `(19,)`.
        known: Covariance of what is believed, shape `(19, 19)`, is added to it with the hypothesis' weight.
        suspicion: Filled with the probability that each suspect is at work, shape `(15,)`.
    """
    covariance, offset = opened.covariance, opened.offset
    seen, mean, spread = np.empty((SLOW, SLOW)), np.empty(SLOW), np.empty((SLOW, SLOW))
    seen[:] = covariance[FAST:, FAST:]
    invert(seen)
    average(settings, state, opened, seen, mean, spread, suspicion)
    gains, crosses = np.empty((FAST, SLOW)), np.empty((FAST, SLOW))
    for row in range(FAST):
        multiply(gains[row], seen, covariance[row, FAST:])
        multiply(crosses[row], spread, gains[row])
    _spread(covariance, gains, crosses, spread, known, state.weight[opened.number])
    for row in range(SLOW):
        move[FAST + row] = mean[row] - state.mean[FAST + row]
    for row in range(POSE):
        move[row] = offset[row]
        for column in range(SLOW):
            move[row] += gains[row, column] * (move[FAST + column] - offset[FAST + column])


@compiled
def _spread(
    covariance: Array, gains: Array, crosses: Array, spread: Array, known: Array, weight: float
) -> None:
    """Add the weighted covariance of what is believed under one hypothesis.

    Args:
        covariance: Covariance of its open filter, shape `(19, 19)`.
        gains: How the fast states follow the slow ones, shape `(7, 11)`.
        crosses: Their covariance with the slow ones, shape `(7, 11)`.
        spread: Covariance of the slow states, shape `(11, 11)`.
        known: What it is added to, shape `(19, 19)`.
        weight: Weight of the hypothesis.
    """
    for row in range(SLOW):
        for column in range(SLOW):
            known[FAST + row, FAST + column] += weight * spread[row, column]
    for row in range(FAST):
        for column in range(SLOW):
            known[row, FAST + column] += weight * crosses[row, column]
            known[FAST + column, row] += weight * crosses[row, column]
        for column in range(row + 1):
            rest = covariance[row, column]
            for middle in range(SLOW):
                rest -= gains[row, middle] * covariance[column, FAST + middle]
                rest += crosses[row, middle] * gains[column, middle]
            known[row, column] += weight * rest
            if column < row:
                known[column, row] += weight * rest
