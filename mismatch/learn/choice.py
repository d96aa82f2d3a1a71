"""Choice of a law: forward selection of candidates by their log density of held-out folds."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.learn.candidates import Curve, Term

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.learn.candidates import Candidate
    from omnimate.mismatch.learn.evidence import Products
    from omnimate.vehicle.se2 import Array

# Declared rate of laws that are learned from noise. Without an error, the Bayes factor of a law has the mean
# 1, and exceeds 1 / rate with at most this probability: Markov's inequality.
FALSE_LAW_RATE = 0.01
MAX_TERMS, MAX_CURVES = 4, 2  # in a law


@dataclass(frozen=True, slots=True)
class Option:
    """A candidate with one of its hyperparameters."""

    candidate: Candidate  # a term or a curve
    members: NDArray[np.int64]  # numbers of its columns, shape `(b,)`
    spread: Array  # prior standard deviations of their coefficients, shape `(b,)`
    price: float  # minus the log of its probability among all options of all kinds [nat]


@dataclass(frozen=True, slots=True)
class Choice:
    """A law as a set of candidates."""

    options: tuple[Option, ...]  # options in the order in which they were chosen; empty for no law
    score: float  # log evidence against no law, less the prices of the options [nat]
    gain: Array  # log density of each fold, predicted from the others, minus that without a law, shape `(K,)`

    @property
    def members(self) -> NDArray[np.int64]:
        """Numbers of the columns of all options, shape `(w,)`."""
        return np.concatenate([option.members for option in self.options])

    @property
    def spread(self) -> Array:
        """Prior standard deviations of their coefficients, shape `(w,)`."""
        return np.concatenate([option.spread for option in self.options])


def options_of(candidates: Sequence[Candidate], scale: float) -> list[Option]:
    """Return every candidate, in the order of their columns, with each of its hyperparameters.

    All kinds of candidates have the same prior probability, and so have all options of one kind: the constant
    is not one among a hundred products. `scale` is the a-priori size of the law, in its unit.
    """
    many = Counter(candidate.kind for candidate in candidates for _ in candidate.spreads)
    options, at = [], 0
    for candidate in candidates:
        members = np.arange(at, at + candidate.basis.shape[1])
        price = math.log(len(many) * many[candidate.kind])
        options += [Option(candidate, members, scale * spread, price) for spread in candidate.spreads]
        at += len(members)
    return options


def choose(products: Products, options: Sequence[Option]) -> Choice:
    """Return the best law: a formula, unless a curve predicts more by more than one standard error.

    The one-standard-error rule is that of Hastie, Tibshirani and Friedman, The Elements of Statistical
    Learning, 2nd edition, 2009, section 7.10; the error is that of the difference in the same folds.
    """
    simple = grow(products, [option for option in options if isinstance(option.candidate, Term)], MAX_TERMS)
    smooth = grow(products, [option for option in options if isinstance(option.candidate, Curve)], MAX_CURVES)
    if not simple.options or not smooth.options:
        return simple if simple.options else smooth
    difference = smooth.gain - simple.gain
    return smooth if difference.sum() > error(difference) else simple


def grow(products: Products, options: Sequence[Option], most: int) -> Choice:
    """Return the options that forward selection chooses, at most `most`.

    Each must raise both the log density of held-out folds and the evidence by more than its price; the first
    one must also exceed the threshold of the declared rate of false laws.
    """
    best = Choice((), 0.0, np.zeros(len(products.cross)))
    for count in range(most):
        taken = {option.candidate for option in best.options}
        free = [option for option in options if option.candidate not in taken]
        threshold = best.score - (0.0 if count else math.log(FALSE_LAW_RATE))
        better = max(_added(products, best, free, threshold), key=_net_gain, default=best)
        if _net_gain(better) <= _net_gain(best):
            break
        best = better
    return best


def _net_gain(choice: Choice) -> float:
    """Return a choice's gain in log density of held-out folds, less the prices of its options [nat]."""
    return float(choice.gain.sum()) - sum(option.price for option in choice.options)


def _added(products: Products, choice: Choice, options: Sequence[Option], threshold: float) -> list[Choice]:
    """Return a choice with each option added whose score is then above a threshold."""
    added = []
    for _, group in groupby(options, key=lambda option: len(option.members)):
        longer = [(*choice.options, option) for option in group]
        members = np.stack([np.concatenate([part.members for part in parts]) for parts in longer])
        spread = np.stack([np.concatenate([part.spread for part in parts]) for parts in longer])
        price = np.array([sum(part.price for part in parts) for parts in longer])
        score = products.evidence(members, spread, left_out=False)[0] - price
        high = np.flatnonzero(score > threshold)
        evidence = products.evidence(members[high], spread[high])
        for number, gain in zip(high, (evidence[0] - evidence[1:]).T, strict=True):
            added.append(Choice(longer[number], float(score[number]), gain))
    return added


def error(gain: Array) -> float:
    """Return the standard error of the sum of the folds' gains `(K,)`."""
    return float(math.sqrt(len(gain)) * np.std(gain, ddof=1))
