"""Laws of unknown errors as terms: learned from the residual of the named effects, and fitted with them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.law import Law
from omnimate.effects.variables import Motion, available_variables
from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.candidates.unknown import errors, sizes_of
from omnimate.mismatch.learn.learn import formula_of, learn

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.mismatch.learn.learn import LearnedLaw
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class LawTerm(Term):
    """A learned law as a term: a column for each coefficient of its formula, or each knot of its curve."""

    law: Law = field(default_factory=lambda: Law("a"))  # the law; its coefficients are in the probes
    summands: tuple[tuple[float, str], ...] = ()  # of its formula: a value, and the text that it multiplies

    def built(self, coefficients: Array) -> Law:
        """Return the law with these coefficients `(k,)` of its probes."""
        if self.law.over:
            probes = [probe for probe in self.probes if isinstance(probe, Law)]
            ordinates = sum(
                (size * np.array(probe.ordinates) for size, probe in zip(coefficients, probes, strict=True)),
                np.zeros(len(self.law.knots)),
            )
            return replace(self.law, ordinates=tuple(np.clip(ordinates, -1.0, 1.0).tolist()))
        values = coefficients * np.array([value for value, _ in self.summands])
        return replace(self.law, formula=formula_of(values, [text for _, text in self.summands]))


def learned(posterior: Posterior, conditional: ConditionalFit, unknown: Term) -> list[LawTerm]:
    """Return the law of an unknown error as terms with unit coefficients; none where none is learned."""
    if not unknown.fixed["acts_on"]:
        return []
    law = law_of(posterior, conditional, unknown.component, unknown.fixed["acts_on"])
    return [] if law is None else _terms(law, unknown.odds)


def law_of(
    posterior: Posterior, conditional: ConditionalFit, component: str, acts_on: str
) -> LearnedLaw | None:
    """Return the law of an error of a component, learned from the residual given a set, or None."""
    return learn(
        *observed(posterior, conditional, component, acts_on),
        conditional.residual,
        posterior.candidates.fold,
        component=component,
        acts_on=acts_on,
        scale=sizes_of(component, acts_on),
    )


def observed(
    posterior: Posterior, conditional: ConditionalFit, component: str, acts_on: str
) -> tuple[dict[str, Array], Callable[[Array], Array]]:
    """Return the variables of which an error may be a function, and its columns.

    Returns:
        Variables of the drive by name, each of shape `(N,)`, and the function from error series `(N, B)` to
        whitened rows `(V, B)`.
    """
    regression = posterior.regression
    names = list(available_variables(component, trucks=len(regression.windows[0].signals.trucks)))
    blocks = [windows.signals.smooth_block for windows in regression.windows]
    motions = [Motion(block, component).values(names) for block in blocks]
    variables = {name: np.concatenate([motion[name] for motion in motions]) for name in names}
    variables = {name: values for name, values in variables.items() if np.all(np.isfinite(values))}
    scale = sizes_of(component, acts_on)
    edges = np.cumsum([len(block) for block in blocks])[:-1]

    def columns(series: Array) -> Array:
        raw = []
        for windows, part in zip(regression.windows, np.split(series, edges), strict=True):
            error = next(
                error for error in errors(windows) if (error.component, error.acts_on) == (component, acts_on)
            )
            raw.append(error.build(part / scale))
        return conditional.project_out(regression.whitened(raw))

    return variables, columns


def _terms(law: LearnedLaw, odds: float) -> list[LawTerm]:
    """Return a learned law as terms."""
    terms = []
    for effect in law.effects:
        summands: tuple[tuple[float, str], ...] = ()
        if effect.over:
            probes = tuple(
                replace(
                    effect, ordinates=tuple(np.where(np.arange(len(effect.knots)) == at, value, 0.0).tolist())
                )
                for at, value in enumerate(effect.ordinates)
            )
        else:
            summands = tuple(zip(law.coefficients.tolist(), law.texts, strict=True))
            probes = tuple(replace(effect, formula=formula_of([value], [text])) for value, text in summands)
        terms.append(LawTerm("law", effect.component, probes, {}, odds, False, 1.0, effect, summands))
    return terms
