"""Learn a law from residuals, as effects: candidates are selected by their log density of held-out folds."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Self

import numpy as np

from omnimate.effects.law import Law
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.learn.candidates import Curve, Term, curves, terms
from omnimate.mismatch.learn.evidence import Products

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.learn.candidates import Candidate
    from omnimate.vehicle.se2 import Array

# Declared rate of laws that are learned from noise. Without an error, the Bayes factor of a law has the mean
# 1, and exceeds 1 / rate with at most this probability: Markov's inequality.
FALSE_LAW_RATE = 0.01
MAX_TERMS, MAX_CURVES = 4, 2  # in a law
CHUNK = 64  # candidates whose columns are computed at once: all of them would need twice the memory
MIN_FOLDS = 3  # one is held out, and among the others each is held out in turn
NOISE_TOLERANCE = 1.05  # [1] a smaller excess of the noise changes no evidence by more than a tenth: 1.05^2


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


@dataclass(frozen=True, slots=True)
class LearnedLaw:
    """A law, and its gain on held-out data."""

    effects: tuple[Law, ...]  # one effect with a formula, or one with a curve for each variable
    texts: tuple[str, ...]  # for each coefficient of a formula the text that it multiplies; empty for curves
    coefficients: Array  # values of the coefficients of a formula, shape `(c,)`
    # log density of each fold, predicted by a law chosen and fitted without it, minus that without a law,
    # shape `(K,)` [nat]
    gain: Array

    @classmethod
    def of(cls, choice: Choice, products: Products, null: Law, gain: Array) -> Self:
        """Return a chosen law as effects.

        Products are in units of the noise; `null` is the law without a formula or a curve.
        """
        values, _ = products.posterior(choice.members, choice.spread)
        terms = [option.candidate for option in choice.options if isinstance(option.candidate, Term)]
        curves = [option.candidate for option in choice.options if isinstance(option.candidate, Curve)]
        if curves:
            parts = slices_of(curve.basis.shape[1] for curve in curves)
            effects = tuple(
                replace(
                    null,
                    over=curve.variable,
                    knots=tuple(curve.knots.tolist()),
                    ordinates=tuple(np.clip(curve.at_knots @ values[part], -1.0, 1.0).tolist()),
                    period=curve.period,
                )
                for curve, part in zip(curves, parts, strict=True)
            )
            return cls(effects, (), np.zeros(0), gain)
        values = values / np.concatenate([term.sizes for term in terms])
        texts = tuple(text for term in terms for text in term.texts)
        return cls((replace(null, formula=formula_of(values, texts)),), texts, values, gain)

    @property
    def total(self) -> float:
        """Held-out gain over all folds [nat]."""
        return float(self.gain.sum())


def formula_of(values: Iterable[float], texts: Sequence[str]) -> str:
    """Return the formula of a sum of texts with a value before each."""
    formula = ""
    for value, text in zip(values, texts, strict=True):
        between = (" - " if value < 0.0 else " + ") if formula else ("-" if value < 0.0 else "")
        formula += f"{between}{abs(value):.6g}" + ("" if text == "1" else f" * {text}")
    return formula


def learn(
    variables: Mapping[str, Array],
    columns: Callable[[Array], Array],
    rows: Array,
    folds: NDArray[np.int64],
    *,
    component: str,
    acts_on: str,
    scale: float,
) -> LearnedLaw | None:
    """Return a law of a residual; None where none predicts held-out data better by a standard error.

    Args:
        variables: Variables on which the law may depend, by their names in `effects.variables`, each of shape
            `(N,)`.
        columns: Function from error series `(N, B)`, in the unit of the law, to what each would add to the
            whitened rows, shape `(R, B)`. It is linear. Parameters that are fitted at the same time, such as
            a diameter, are projected out of its columns and of the rows.
        rows: Whitened residual, shape `(R,)`: noise of unit variance plus the effect of the law.
        folds: Number of the block of time of each row, shape `(R,)`; at least three different ones.
        component: Component on which the law acts.
        acts_on: Quantity that it changes, one of `effects.law.quantities(component)`.
        scale: A-priori size of the law in its unit, to a factor of some ten.

    Raises:
        SimulationError: The component does not have the quantity or a variable.
        ValueError: A variable is not finite, or there are fewer than three folds.
    """
    null = Law(component, acts_on)
    Law(component, acts_on, " + ".join(variables))  # raises for variables that the component does not have
    for name, values in variables.items():
        if not np.all(np.isfinite(values)):
            raise ValueError(f"variable {name} is not finite; expected a number at every step")
    if len(np.unique(folds)) < MIN_FOLDS:
        raise ValueError(f"{len(np.unique(folds))} folds; expected at least {MIN_FOLDS}")
    candidates: list[Candidate] = [*terms(variables), *curves(variables)]
    parts = [candidates[first : first + CHUNK] for first in range(0, len(candidates), CHUNK)]
    whitened = [columns(np.hstack([candidate.basis for candidate in part])) for part in parts]
    options = options_of(candidates, scale)
    products, choice = _scaled_to_noise(Products.of(np.hstack(whitened), rows, folds), options)
    if not choice.options:
        return None
    gain = np.array([_heldout_gain(products, fold, options) for fold in range(len(products.cross))])
    if gain.sum() <= error(gain):
        return None
    return LearnedLaw.of(choice, products, null, gain)


def _scaled_to_noise(products: Products, options: Sequence[Option]) -> tuple[Products, Choice]:
    """Return the products in units of the noise given the chosen law, and the law."""
    while True:
        choice = choose(products, options)
        excess = products.noise(choice.members, choice.spread) if choice.options else 1.0
        if excess < NOISE_TOLERANCE:
            return products, choice
        products = products.scaled(excess)


def _heldout_gain(products: Products, fold: int, options: Sequence[Option]) -> float:
    """Return the gain in log density of a fold by the law that is chosen without it [nat]."""
    choice = choose(products.without(fold), options)
    if not choice.options:
        return 0.0
    evidence = products.evidence(choice.members[None], choice.spread[None])[:, 0]
    return float(evidence[0] - evidence[1 + fold])


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
