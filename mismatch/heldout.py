"""How far effects help where no parameter has seen the data: laps or blocks left out in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.evidence.rows import whiten_nuisances
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
_MOST = 0.8  # of what tells a parameter may lie in the stretch that is left out


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Whitened residuals, row by row.

    Attributes:
        before: (V,) of the nominal robot.
        train: (V,) with effects fitted to everything.
        after: (V,) with effects fitted to the other folds.
        gain: of each fold, by how much half the chi-square falls.
        effects: of each fold, as fitted to the other folds.
        kind: of stretches that were left out in turn.
        folds: of each recording (M + 1,) the number of each window's.
    """

    before: Array
    train: Array
    after: Array
    gain: Array
    effects: tuple[tuple[Effect, ...], ...]
    kind: Kind
    folds: tuple[NDArray[np.int64], ...]


def held_out(
    nominal: Regression, fit: Fitted, kind: Kind | None = None, without: Container[int] = ()
) -> HeldOut:
    """Return the residuals of the nominal robot and of the effects, fitted with and without each fold.

    What every robot has is noise to both, and is integrated out of them.

    Events count as one parameter for each wheel: what a bump costs is learnt from the bumps of other
    laps, only its moment is taken from its own.

    Args:
        nominal: The recordings whitened about no effect, in the windows of the fit.
        fit: The effects.
        kind: Of stretches to leave out; where none is given, the longest that all parameters allow.
        without: Numbers of effects of the fit that are not fitted; `train` then has what they explained.
    """
    before = whiten_nuisances(nominal.white[:, :1], fit.nuisance)[:, 0]
    regression = fit.regression
    rows = fit.rows
    everything = list(enumerate(fit.everything()))
    removed = [rows[:, place] @ values for number, (_, place, values) in everything if number in without]
    train = sum(removed, rows[:, 0])
    after = train.copy()
    kept = [acting for number, acting in everything if number not in without]
    columns, origin = _shared(kept, rows)
    kind = kind or _kind(regression, columns)
    stretches = tuple(folds_of(regression.windows, kind))
    folds = regression.of_rows(stretches)
    effects, gain = [], []
    for fold in range(max(int(own.max()) for own in stretches) + 1):  # nothing may be measured in some
        mine = folds == fold
        others = columns[~mine]
        # the base already holds the fit to everything; what other folds say is a step away from it
        target = train[~mine] + others @ origin
        precision = others.T @ others + np.eye(columns.shape[1])
        known = np.linalg.solve(precision, others.T @ target)
        after[mine] = train[mine] - columns[mine] @ (known - origin)
        gain.append(0.5 * float((before[mine] ** 2 - after[mine] ** 2).sum()))
        effects.append(_built(kept, known))
    return HeldOut(before, train, after, np.array(gain), tuple(effects), kind, stretches)


def nominal_of(fit: Fitted) -> Regression:
    """Return the recordings of a fit whitened about the robot as described, and its references as mounted."""
    return Regression(fit.regression.windows, fit.regression.noise, fit.mounted)


def predicts_better(richer: Fitted, simpler: Fitted) -> bool:
    """Say whether effects predict unseen data better than others, by more than a standard error.

    The one-standard-error rule is that of Hastie, Tibshirani and Friedman, The Elements of Statistical
    Learning, 2nd edition, 2009, section 7.10.
    """
    with_more = held_out(nominal_of(richer), richer)
    more = with_more.gain - held_out(nominal_of(simpler), simpler, with_more.kind).gain
    return float(more.sum()) > float(np.sqrt(len(more)) * more.std(ddof=1)) if len(more) > 1 else True


def _kind(fitted: Regression, columns: Array) -> Kind:
    """Return the longest stretches that may be left out, all parameters being told by the rest."""
    whole = (columns**2).sum(axis=0)
    for kind in ("laps", "blocks"):
        folds = fitted.of_rows(folds_of(fitted.windows, kind))
        inside = [(columns[folds == fold] ** 2).sum(axis=0) for fold in range(int(folds.max()) + 1)]
        if np.all(np.max(inside, axis=0) < _MOST * whole):
            return kind
    return "moments"


def _shared(acting: Sequence[tuple[Term, slice, Array]], rows: Array) -> tuple[Array, Array]:
    """Return columns (V, k) of rows, all events of a wheel in one, and the coefficients (k,) of the base."""
    columns, origin = [], []
    for term, place, values in acting:
        own = rows[:, place]
        if term.is_unknown:
            continue  # no other moment tells what one push was
        if term.is_event and own.shape[1] > 1:
            mean = float(values.mean())
            shape = values / mean if abs(mean) > 1e-9 else np.ones_like(values)
            columns.append((own * shape).sum(axis=1))
            origin.append(mean)
        else:
            columns += list(own.T)
            origin += values.tolist()
    if not columns:
        return np.zeros((len(rows), 0)), np.zeros(0)
    return np.stack(columns, axis=1), np.array(origin)


def _built(acting: Sequence[tuple[Term, slice, Array]], shared: Array) -> tuple[Effect, ...]:
    """Return the effects that shared coefficients (k,) stand for."""
    effects, at = [], 0
    for term, _, values in acting:
        if term.is_unknown:
            effects.append(term.built(values))
        elif term.is_event and len(values) > 1:
            effects.append(term.built(np.full(len(values), shared[at])))
            at += 1
        else:
            effects.append(term.built(shared[at : at + len(values)]))
            at += len(values)
    return tuple(effects)


def size(rows: Array) -> float:
    """Return the root mean square of rows; 1.0 where there are none."""
    return float(np.sqrt(np.mean(rows**2))) if len(rows) else 1.0
