"""A learned law, and how it is written down as effects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from scipy.linalg import block_diag

from omnimate.mismatch.learn.candidates import Curve, Term
from omnimate.mismatch.learn.choice import error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.law import Law
    from omnimate.mismatch.learn.choice import Choice
    from omnimate.mismatch.learn.evidence import Products
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class LearnedLaw:
    """A law with its uncertainty, and what it is worth on data that it has not seen.

    Attributes:
        effects: The law: one effect with a formula, or one with a curve for each variable.
        names: Of each coefficient, the text that it multiplies, or the knot whose ordinate it is.
        units: Unit of each coefficient.
        coefficients: Their values, shape `(c,)`.
        covariance: Their covariance, shape `(c, c)`.
        gain: By how much the log density of each fold is higher than without a law, where the law was chosen
            and fitted without that fold, shape `(K,)` [nat].
        noise: Size of the noise that was assumed; 1 where the rows were whitened well.
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
            products: What the rows say, in units of the noise.
            null: Law of the component and the quantity, without a formula or a curve.
            gain: As in the attributes.
            noise: As in the attributes.
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
            effects = (replace(null, formula=_sum(values, names)),)
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
        return [{"ordinates": own.tolist()} for own in np.split(deviation, len(self.effects))]


def _with_curves(null: Law, curves: Sequence[Curve], ordinates: Sequence[Array]) -> tuple[Law, ...]:
    """Return one law for each curve; all have as many knots."""
    return tuple(
        replace(
            null,
            over=curve.variable,
            knots=tuple(curve.knots.tolist()),
            ordinates=tuple(own.tolist()),
            period=curve.period,
        )
        for curve, own in zip(curves, ordinates, strict=True)
    )


def _sum(values: Array, texts: Sequence[str]) -> str:
    """Return the formula of a sum."""
    formula = ""
    for value, text in zip(values, texts, strict=True):
        between = (" - " if value < 0.0 else " + ") if formula else ("-" if value < 0.0 else "")
        formula += f"{between}{abs(value):.6g}" + ("" if text == "1" else f" * {text}")
    return formula
