"""The prior of the slow states: each suspect is absent, or present with an unknown size; compiled.

The slow states of an open filter have a nearly flat prior, so that they represent the likelihood alone. The
estimate adds a spike-and-slab prior (Mitchell and Beauchamp, *JASA* 1988): a suspect is absent, or present
with a standard deviation of `prior.SUSPECT_SIZES` or a part of it. All sets of up to two suspects are
averaged by their probability, so that explanations with the same readings share it.

Let P0 be the prior information of correct values, L that of the readings, S = (P0 + L)^-1, m the mean of the
slow states without suspects, and U the directions of the suspects in them. Given the sizes c of the suspects
the mean is m + S P0 U' c, and the likelihood of c is exp(p'c - c'Wc / 2) with the pull p = U P0 m and the
information W = U (P0 - P0 S P0) U'.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.records import (
    FAST,
    SLOW,
    SUSPECT_COUNT,
    VALUE_COUNT,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.matrices import add_outer, add_scaled, invert, multiply, product

if TYPE_CHECKING:
    Moments = tuple[float, float, float, float, float, float]

SCALES = 3  # equally probable standard deviations of the suspects in a set, each a third of the previous one
NEGLIGIBLE = math.exp(-12.0)  # probability of a set; all those below change a variance by 5 % at most

SCALED = 300.0  # log probability above which the sums are scaled again: the exponential of 709 overflows


@compiled
def moments_of_two(
    first: float, second: float, inside: tuple[float, float, float], pull: tuple[float, float]
) -> Moments:
    """Return the moments of the sizes of two suspects, or of one, given that they are present.

    Their prior variances are `first` and `second`, 0 where there is one only. `inside` is the information on
    the first size, on both, and on the second; `pull` the pull of each.

    Returns:
        Both means; variance of the first size, covariance, variance of the second; and the determinant of
        prior over posterior covariance. The log of the likelihood, over that with both sizes 0, is
        (means times pulls - log of the determinant) / 2.
    """
    own, cross, other = 1.0 + first * inside[0], first * inside[1], 1.0 + second * inside[2]
    determinant = own * other - cross * second * inside[1]
    scale = 1.0 / determinant
    variance, covariance, rest = scale * first * other, -scale * cross * second, scale * second * own
    mean = variance * pull[0] + covariance * pull[1]
    return mean, covariance * pull[0] + rest * pull[1], variance, covariance, rest, determinant


@compiled
def average_sets(settings: FilterSettings, inside: Array, pull: Array) -> tuple[Array, Array, Array]:
    """Average the sizes of the suspects over all sets of up to two of them.

    `inside` `(17, 17)` is the information on the sizes by the readings, `pull` `(17,)` their pull. Returned
    are the means of the sizes `(17,)`, their covariance `(17, 17)`, and the probabilities that each of
    `prior.VALUE_NAMES` is wrong `(9,)`.
    """
    best, total = 0.0, 1.0  # of the empty set
    mean, wrong = np.zeros(SUSPECT_COUNT), np.zeros(VALUE_COUNT)
    square, present = np.zeros((SUSPECT_COUNT, SUSPECT_COUNT)), np.zeros((SUSPECT_COUNT, SUSPECT_COUNT))
    for apart in range(SUSPECT_COUNT):  # 0: a suspect alone
        for first in range(SUSPECT_COUNT - apart):
            second = first + apart
            best, total = add_set(
                settings, inside, pull, (first, second), (best, total), mean, square, present
            )
    mean /= total
    for row in range(SUSPECT_COUNT):
        for column in range(row, SUSPECT_COUNT):
            square[row, column] = square[row, column] / total - mean[row] * mean[column]
            square[column, row] = square[row, column]
            if present[row, column] > 0.0:
                for value in range(VALUE_COUNT):
                    if settings.suspect_value[row, value] or settings.suspect_value[column, value]:
                        wrong[value] += present[row, column] / total
    return mean, square, wrong


@compiled
def add_set(
    settings: FilterSettings,
    inside: Array,
    pull: Array,
    members: tuple[int, int],
    so_far: tuple[float, float],
    mean: Array,
    square: Array,
    present: Array,
) -> tuple[float, float]:
    """Add a suspect, or two, with all of their scales to the sums over sets; arguments as in `average_sets`.

    `so_far` is the log of a probability, and the sum of all probabilities over it; returned as they are
    afterwards. `members` are equal for one suspect alone.
    """
    first, second = members
    best, total = so_far
    known = inside[first, first], inside[first, second], inside[second, second]
    pulls = pull[first], pull[second]
    variance, other_variance = settings.size[first] ** 2, settings.size[second] ** 2
    prior = settings.odds - math.log(SCALES)
    if first == second:
        other_variance = 0.0
    else:
        prior += settings.odds
    for _ in range(SCALES):
        mean_1, mean_2, square_1, shared, square_2, determinant = moments_of_two(
            variance, other_variance, known, pulls
        )
        variance /= 9.0
        other_variance /= 9.0
        evidence = prior + 0.5 * (mean_1 * pulls[0] + mean_2 * pulls[1])
        if evidence > best + SCALED:
            shrunk = math.exp(best - evidence)
            best = evidence
            total *= shrunk
            mean *= shrunk
            square *= shrunk
            present *= shrunk
        weight = math.exp(evidence - best) / math.sqrt(determinant)
        if weight < total * NEGLIGIBLE:
            continue
        total += weight
        mean[first] += weight * mean_1
        square[first, first] += weight * (square_1 + mean_1 * mean_1)
        present[first, second] += weight
        if first != second:
            mean[second] += weight * mean_2
            square[second, second] += weight * (square_2 + mean_2 * mean_2)
            square[first, second] += weight * (shared + mean_1 * mean_2)
    return best, total


@compiled
def discard_common_scale(information: Array, pull: Array, variance: float) -> None:
    """Remove the information on the common scale of all wheels from a likelihood, in place.

    At the start and end of a bend the joints show that scale, but a late reading and a compliant drive look
    the same there; only absolute poses can separate them. `information` `(11, 11)` is that on the slow states
    by the readings, `pull` `(11,)` its product with their mean, `variance` that of the apparent error of the
    scale.
    """
    product, inside, pulled = np.zeros(SLOW), 1.0 / variance, 0.0
    for wheel in range(4):
        add_scaled(product, 1.0, information[wheel])
        pulled += pull[wheel]
    for wheel in range(4):
        inside += product[wheel]
    add_scaled(pull, -pulled / inside, product)
    add_outer(information, -1.0 / inside, product)


@compiled
def size_likelihood(settings: FilterSettings, spread: Array, mean: Array) -> tuple[Array, Array, Array]:
    """Return the likelihood of the suspects' sizes.

    `spread` `(11, 11)` is the covariance S of the slow states without suspects, `mean` `(11,)` their mean.
    Returned are what the sizes add to the mean, U P0 S `(17, 11)`; the information W on them `(17, 17)`; and
    their pull `(17,)`.
    """
    carried = np.empty((SUSPECT_COUNT, SLOW))
    inside, pull = settings.suspect_precision.copy(), np.zeros(SUSPECT_COUNT)
    for row in range(SUSPECT_COUNT):
        direction = settings.suspect_information[row]
        multiply(carried[row], spread, direction)
        for middle in range(SLOW):
            pull[row] += direction[middle] * mean[middle]
        for column in range(row + 1):
            for middle in range(SLOW):
                inside[row, column] -= carried[row, middle] * settings.suspect_information[column, middle]
            inside[column, row] = inside[row, column]
    return carried, inside, pull


@compiled
def add_suspects(settings: FilterSettings, spread: Array, mean: Array) -> Array:
    """Add the suspects to covariance `(11, 11)` and mean `(11,)` of the slow states, in place.

    Returned are the probabilities that each of `prior.VALUE_NAMES` is wrong, `(9,)`.
    """
    carried, inside, pull = size_likelihood(settings, spread, mean)
    sizes, scatter, wrong = average_sets(settings, inside, pull)
    scattered = np.zeros((SUSPECT_COUNT, SLOW))
    product(scattered, scatter, carried)
    for suspect in range(SUSPECT_COUNT):
        for row in range(SLOW):
            mean[row] += sizes[suspect] * carried[suspect, row]
            for column in range(SLOW):
                spread[row, column] += carried[suspect, row] * scattered[suspect, column]
    return wrong


@compiled
def average_slow_states(
    settings: FilterSettings, state: FilterState, opened: OpenFilter
) -> tuple[Array, Array, Array, Array]:
    """Return the posterior of the slow states from an open filter and the prior.

    It is the inverse covariance of the open filter's slow states `(11, 11)`, their mean `(11,)` and
    covariance `(11, 11)` with the prior, and the probabilities that each of `prior.VALUE_NAMES` is wrong
    `(9,)`.
    """
    information = opened.covariance[FAST:, FAST:].copy()
    invert(information)
    spread, pull, mean = np.zeros((SLOW, SLOW)), np.empty(SLOW), state.mean[FAST:].copy()
    add_scaled(mean, 1.0, opened.offset[FAST:])
    for row in range(SLOW):
        add_scaled(spread[row], settings.independent_share, information[row])
    multiply(pull, spread, mean)
    for row in range(SLOW):
        spread[row, row] -= settings.independent_share / settings.open_variance[row]
    if state.fix_count == 0:
        discard_common_scale(spread, pull, settings.open_variance[0])
    for row in range(SLOW):
        add_scaled(spread[row], 1.0, settings.nominal_information[row])
    invert(spread)
    multiply(mean, spread, pull)
    wrong = add_suspects(settings, spread, mean)
    return information, mean, spread, wrong
