"""Learn a law from residuals, as effects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from omnimate.effects.law import Law
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.learn.candidates import Curve, Term, curves, terms
from omnimate.mismatch.learn.choice import choose, error, options_of
from omnimate.mismatch.learn.evidence import Products

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.learn.candidates import Candidate
    from omnimate.mismatch.learn.choice import Choice, Option
    from omnimate.vehicle.se2 import Array

CHUNK = 64  # candidates whose columns are computed at once: all of them would need twice the memory
MIN_FOLDS = 3  # one is held out, and among the others each is held out in turn
NOISE_TOLERANCE = 1.05  # [1] a smaller excess of the noise changes no evidence by more than a tenth: 1.05^2


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
                    ordinates=tuple((curve.at_knots @ values[part]).tolist()),
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
