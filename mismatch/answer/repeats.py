"""Whether a finding repeats: its size in each recording alone, and whether these sizes agree."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc

from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.diagnosis import Parameter, Repeats
from omnimate.mismatch.evidence.rows import whiten_nuisances
from omnimate.mismatch.fit import prior_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.fit import Fitted
    from omnimate.vehicle.se2 import Array

Estimate = tuple["Array", "Array"]  # coefficients (k,) of an effect, and their covariance (k, k)


def repeats_of(fit: Fitted, effects: int) -> list[Repeats | None]:
    """Return how the first `effects` of a fit, which have a name, repeat in its recordings, given all else.

    None where it cannot repeat: there is one recording, or it acts at some moments only.
    """
    count = len(fit.regression.windows)
    alone = [_alone(fit, recording) for recording in range(count)] if count > 1 and effects else []
    return [
        None if term.is_local or not alone else _repeats(term, values, [fits[number] for fits in alone])
        for number, (term, values) in enumerate(
            zip(fit.chosen.terms[:effects], fit.chosen.values[:effects], strict=True)
        )
    ]


def _alone(fit: Fitted, recording: int) -> list[Estimate]:
    """Return every effect's coefficients and their covariance by one recording, all being fitted to it."""
    rows = fit.regression.owner == recording
    columns, data = fit.linear_model(whiten_nuisances(fit.regression.white[rows], fit.nuisance[rows]))
    prior = prior_of([term for term, _, _ in fit.everything()], len(fit.chosen.terms))
    precision = columns.T @ columns + prior
    covariance: Array = np.linalg.inv(precision).astype(np.float64)
    coefficients: Array = covariance @ (columns.T @ data)
    parts = slices_of(len(values) for _, _, values in fit.everything())
    return [(coefficients[part], covariance[part, part]) for part in parts]


def _repeats(term: Term, values: Array, alone: Sequence[Estimate]) -> Repeats:
    """Return how coefficients (k,) repeat: Cochran's Q of a meta-analysis (Biometrics 10, 1954).

    The law is not exact: from recording to recording, the size may vary by the declared discrepancy.
    """
    inexact = (term.discrepancy * float(np.linalg.norm(values))) ** 2 * np.eye(len(values))
    estimates = np.stack([coefficients for coefficients, _ in alone])
    information = np.stack([np.linalg.inv(covariance + inexact) for _, covariance in alone])
    mean = np.linalg.solve(information.sum(axis=0), np.einsum("rij,rj->i", information, estimates))
    away = estimates - mean
    square = float(np.einsum("ri,rij,rj->", away, information, away))
    freedom = len(values) * (len(alone) - 1)
    effects = [term.built(coefficients) for coefficients in estimates]
    spreads = [
        term.sigmas(effect, covariance)[term.linear]
        for effect, (_, covariance) in zip(effects, alone, strict=True)
    ]
    parameter = Parameter(
        term.linear,
        tuple(float(getattr(effect, term.linear)) for effect in effects),
        tuple(float(np.max(spread)) for spread in spreads),
        term.kind.estimated().unit,
    )
    return Repeats(parameter, float(chdtrc(freedom, square)))
