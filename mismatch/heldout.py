"""How far effects help where no parameter has seen the data: laps or blocks left out in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag, eigvalsh

from omnimate.mismatch.candidates.regression import Regression, slices_of
from omnimate.mismatch.evidence.rows import whiten_nuisances
from omnimate.mismatch.fit import prior_of
from omnimate.mismatch.recording.folds import folds_of

if TYPE_CHECKING:
    from collections.abc import Container, Sequence

    from numpy.typing import NDArray

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.fit import Fitted
    from omnimate.mismatch.recording.folds import Kind
    from omnimate.vehicle.se2 import Array

METRIC = "root mean square of the whitened innovations (1.0 = the noise that is expected); held out: {}"
HELD = {
    "laps": "each lap, or block of time, with effects fitted to the others",
    "blocks": "every fourth block of 8 s, with effects fitted to the others: some act in one lap only",
    "moments": "every other half second, with effects fitted to the others: some act at one moment only",
}
_MOST = 0.8  # of the information on any combination of parameters may lie in the stretch that is left out


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Whitened residuals, row by row."""

    before: Array  # (V,) of the nominal robot
    train: Array  # (V,) with effects fitted to everything
    after: Array  # (V,) with effects fitted to the other folds
    gain: Array  # of each fold, by how much half the chi-square falls
    effects: tuple[tuple[Effect, ...], ...]  # of each fold, as fitted to the other folds
    kind: Kind  # of stretches that were left out in turn
    folds: tuple[NDArray[np.int64], ...]  # of each recording (M + 1,) the number of each window's


def held_out(fit: Fitted, kind: Kind | None = None, without: Container[int] = ()) -> HeldOut:
    """Return the residuals of the nominal robot and of the effects, fitted with and without each fold.

    The nominal robot is the one as described, and its references as mounted. What every robot has is noise to
    both, and is integrated out of them.

    Events count as one parameter for each wheel: what a bump costs is learnt from the bumps of other laps,
    only its moment is taken from its own. Where no kind of stretches is given, the longest that all
    parameters allow are left out. Effects with a number in `without` are not fitted: `train` has what they
    explained.
    """
    before = whiten_nuisances(fit.data_about(fit.mounted)[:, None], fit.nuisance)[:, 0]
    regression, rows = fit.regression, fit.rows
    everything = list(enumerate(fit.everything()))
    removed = [rows[:, place] @ values for number, (_, place, values) in everything if number in without]
    train = sum(removed, rows[:, 0])
    kept = [acting for number, acting in everything if number not in without]
    terms, values = [term for term, _, _ in kept], [coefficients for _, _, coefficients in kept]
    known, shared = _shared(terms, values)
    chosen = sum(number not in without for number in range(len(fit.chosen.terms)))
    prior = shared.T @ prior_of(terms, chosen) @ shared
    columns = np.hstack([rows[:, :0], *(rows[:, place] for _, place, _ in kept)])
    # the base already holds the fit to everything; what other folds say is a step away from it
    target = train + columns @ (np.concatenate([known[:0], *values]) - known)
    columns = columns @ shared
    kind = kind or _kind(regression, columns, prior)
    stretches = tuple(folds_of(regression.windows, kind))
    folds = regression.of_rows(stretches)
    parts = slices_of(map(len, values))
    after, effects, gain = train.copy(), [], []
    for fold in range(
        max(int(numbers.max()) for numbers in stretches) + 1
    ):  # nothing may be measured in some
        left_out = folds == fold
        others = columns[~left_out]
        sizes = np.linalg.solve(others.T @ others + prior, others.T @ target[~left_out])
        after[left_out] = target[left_out] - columns[left_out] @ sizes
        gain.append(0.5 * float((before[left_out] ** 2 - after[left_out] ** 2).sum()))
        fitted = known + shared @ sizes
        effects.append(tuple(term.built(fitted[part]) for term, part in zip(terms, parts, strict=True)))
    return HeldOut(before, train, after, np.array(gain), tuple(effects), kind, stretches)


def predicts_better(richer: Fitted, simpler: Fitted) -> bool:
    """Say whether effects predict unseen data better than others, by more than a standard error.

    The one-standard-error rule is that of Hastie, Tibshirani and Friedman, The Elements of Statistical
    Learning, 2nd edition, 2009, section 7.10.
    """
    with_more = held_out(richer)
    gain = with_more.gain - held_out(simpler, with_more.kind).gain
    return float(gain.sum()) > float(np.sqrt(len(gain)) * gain.std(ddof=1)) if len(gain) > 1 else True


def _kind(fitted: Regression, columns: Array, prior: Array) -> Kind:
    """Return the longest stretches that may be left out, all parameters being identified by the rest.

    So must every combination of them be: a lap to one side does not separate a wheelbase from unequal wheels.
    """
    total = columns.T @ columns + prior
    for kind in ("laps", "blocks"):
        folds = fitted.of_rows(folds_of(fitted.windows, kind))
        parts = [columns[folds == fold] for fold in range(int(folds.max()) + 1)]
        if all(eigvalsh(part.T @ part, total).max(initial=0.0) < _MOST for part in parts):
            return kind
    return "moments"


def _shared(terms: Sequence[Term], values: Sequence[Array]) -> tuple[Array, Array]:
    """Return coefficients (K,) that no other stretch has, and how the others depend on shared ones, (K, k).

    All events of a wheel have one size in common; only its own moment shows what a push was.
    """
    known, shared = [np.zeros(0)], []
    for term, coefficients in zip(terms, values, strict=True):
        known.append(coefficients if term.is_unknown else np.zeros(len(coefficients)))
        equal = np.ones((len(coefficients), 1)) if term.is_event else np.eye(len(coefficients))
        shared.append(equal[:, : 0 if term.is_unknown else None])
    return np.concatenate(known), block_diag(np.zeros((0, 0)), *shared)


def size(rows: Array) -> float:
    """Return the root mean square of rows; 1.0 where there are none."""
    return float(np.sqrt(np.mean(rows**2))) if len(rows) else 1.0
