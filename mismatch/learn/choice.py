"""Which candidates make a law: forward selection by what they predict of folds that they have not seen."""

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

# Declared rate of laws that are learned from noise. Where there is nothing, the Bayes factor of a law
# has the mean 1, and exceeds 1 / rate with at most this probability: Markov's inequality.
FALSE = 0.01
TERMS, CURVES = 4, 2  # in a law, at most


@dataclass(frozen=True, slots=True)
class Option:
    """A candidate with one of its hyperparameters.

    Attributes:
        candidate: A term or a curve.
        members: Its columns, shape `(b,)`.
        spread: Prior standard deviations of their coefficients, shape `(b,)`.
        price: Minus the log of its probability among all options of all kinds [nat].
    """

    candidate: Candidate
    members: NDArray[np.int64]
    spread: Array
    price: float


@dataclass(frozen=True, slots=True)
class Choice:
    """Candidates that make a law together.

    Attributes:
        options: In the order in which they were chosen; none is no law.
        score: Log evidence against no law, less the prices of the options [nat].
        gain: By how much the log density of each fold is higher than without a law, predicted from the
            others, shape `(K,)`.
    """

    options: tuple[Option, ...]
    score: float
    gain: Array

    @property
    def members(self) -> NDArray[np.int64]:
        """Columns of all options, shape `(w,)`."""
        return np.concatenate([option.members for option in self.options])

    @property
    def spread(self) -> Array:
        """Prior standard deviations of their coefficients, shape `(w,)`."""
        return np.concatenate([option.spread for option in self.options])


def options_of(candidates: Sequence[Candidate], scale: float) -> list[Option]:
    """Return every candidate with each of its hyperparameters.

    All kinds of candidates are equally likely, and so are all options of one kind: the constant is not one
    among a hundred products.

    Args:
        candidates: Candidates in the order of their columns.
        scale: A-priori size of the law, in its unit.
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
    simple = grow(products, [option for option in options if isinstance(option.candidate, Term)], TERMS)
    smooth = grow(products, [option for option in options if isinstance(option.candidate, Curve)], CURVES)
    if not simple.options or not smooth.options:
        return simple if simple.options else smooth
    more = smooth.gain - simple.gain
    return smooth if more.sum() > error(more) else simple


def grow(products: Products, options: Sequence[Option], most: int) -> Choice:
    """Return the options that forward selection adds to nothing, one after the other.

    Each must raise the log density of unseen folds by more than its price, and so must its evidence; the
    first one must also pay for the declared false rate.
    """
    best = Choice((), 0.0, np.zeros(len(products.cross)))
    for count in range(most):
        taken = {option.candidate for option in best.options}
        free = [option for option in options if option.candidate not in taken]
        threshold = best.score - (0.0 if count else math.log(FALSE))
        better = max(_added(products, best, free, threshold), key=_worth, default=best)
        if _worth(better) <= _worth(best):
            break
        best = better
    return best


def _worth(choice: Choice) -> float:
    """Return by how much a choice raises the log density of unseen folds, less the prices of its options."""
    return float(choice.gain.sum()) - sum(option.price for option in choice.options)


def _added(products: Products, choice: Choice, options: Sequence[Option], threshold: float) -> list[Choice]:
    """Return a choice with each option added that lifts the score above a threshold."""
    added = []
    for _, group in groupby(options, key=lambda option: len(option.members)):
        longer = [(*choice.options, option) for option in group]
        members = np.stack([np.concatenate([one.members for one in own]) for own in longer])
        spread = np.stack([np.concatenate([one.spread for one in own]) for own in longer])
        price = np.array([sum(one.price for one in own) for own in longer])
        score = products.evidence(members, spread, left_out=False)[0] - price
        high = np.flatnonzero(score > threshold)
        evidence = products.evidence(members[high], spread[high])
        for number, gain in zip(high, (evidence[0] - evidence[1:]).T, strict=True):
            added.append(Choice(longer[number], float(score[number]), gain))
    return added


def error(gain: Array) -> float:
    """Return the standard error of the sum of the folds' gains `(K,)`."""
    return float(math.sqrt(len(gain)) * np.std(gain, ddof=1))
