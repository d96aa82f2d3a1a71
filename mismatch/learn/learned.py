"""A learned law, and its form as effects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from scipy.linalg import block_diag

from omnimate.mismatch.learn.candidates import Curve, Term
from omnimate.mismatch.learn.choice import error

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.effects.law import Law
    from omnimate.mismatch.learn.choice import Choice
    from omnimate.mismatch.learn.evidence import Products
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class LearnedLaw:
    """A law with its uncertainty, and its gain on held-out data.

    Attributes:
        effects: One effect with a formula, or one with a curve for each variable.
        names: For each coefficient the text that it multiplies, or the knot whose ordinate it is.
        units: Unit of each coefficient.
        coefficients: Values of the coefficients, shape `(c,)`.
        covariance: Covariance of the coefficients, shape `(c, c)`.
        gain: Log density of each fold, predicted by a law chosen and fitted without it, minus that without a
            law, shape `(K,)` [nat].
        noise: Assumed standard deviation of the rows; 1 where they were whitened correctly.
    """

    effects: tuple[Law, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    coefficients: Array
    covariance: Array
    gain: Array
    noise: float

    @classmethod
    def of(cls, choice: Choice, products: Products, null: Law, gain: Array, noise: float) -> Self:
        """Return a chosen law as effects.

        Args:
            choice: Terms or curves; at least one.
            products: Products of the rows, in units of the noise.
            null: Law of the component and the quantity, without a formula or a curve.
            gain: Attribute of the law.
            noise: Likewise.
        """
        values, covariance = products.posterior(choice.members, choice.spread)
        terms = [option.candidate for option in choice.options if isinstance(option.candidate, Term)]
        curves = [option.candidate for option in choice.options if isinstance(option.candidate, Curve)]
        if curves:
            by = block_diag(*(curve.at_knots for curve in curves))
            values, covariance = by @ values, by @ covariance @ by.T
            effects = _with_curves(null, curves, np.split(values, len(curves)))
            names = [f"{curve.variable} = {knot:.6g}" for curve in curves for knot in curve.knots]
            units = [null.unit] * len(names)
        else:
            by = 1.0 / np.concatenate([term.sizes for term in terms])
            values, covariance = by * values, by[:, None] * covariance * by
            names = [text for term in terms for text, _ in term.texts]
            effects = (replace(null, formula=formula_of(values, names)),)
            of = [unit for term in terms for _, unit in term.texts]
            units = [null.unit if unit == "1" else f"{null.unit} / ({unit})" for unit in of]
        return cls(effects, tuple(names), tuple(units), values, covariance, gain, noise)

    @property
    def total(self) -> float:
        """Held-out gain over all folds [nat]."""
        return float(self.gain.sum())

    @property
    def error(self) -> float:
        """Standard error of the held-out gain [nat]."""
        return error(self.gain)

    def sigmas(self) -> list[dict[str, float | list[float]]]:
        """Return the standard deviations for each effect, as an effects file takes them."""
        deviation = np.sqrt(np.diag(self.covariance))
        if not self.effects[0].over:
            return [dict(zip(self.names, deviation.tolist(), strict=True))]
        return [{"ordinates": of_curve.tolist()} for of_curve in np.split(deviation, len(self.effects))]


def _with_curves(null: Law, curves: Sequence[Curve], ordinates: Sequence[Array]) -> tuple[Law, ...]:
    """Return one law for each curve; all have as many knots."""
    return tuple(
        replace(
            null,
            over=curve.variable,
            knots=tuple(curve.knots.tolist()),
            ordinates=tuple(of_curve.tolist()),
            period=curve.period,
        )
        for curve, of_curve in zip(curves, ordinates, strict=True)
    )


def formula_of(values: Iterable[float], texts: Sequence[str]) -> str:
    """Return the formula of a sum of texts with a value before each."""
    formula = ""
    for value, text in zip(values, texts, strict=True):
        between = (" - " if value < 0.0 else " + ") if formula else ("-" if value < 0.0 else "")
        formula += f"{between}{abs(value):.6g}" + ("" if text == "1" else f" * {text}")
    return formula
