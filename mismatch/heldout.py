"""How far effects help where no parameter has seen the data: laps or blocks left out in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mismatch.refine import Refined
    from mismatch.regression import Regression
    from vcan_sim.effects.effect import Effect
    from vehicle.se2 import Array

METRIC = (
    "root mean square of the whitened innovations (1.0 = the sensors' own noise); "
    "held out: each lap or block predicted with effects fitted to the others"
)


@dataclass(frozen=True, slots=True)
class HeldOut:
    """Whitened residuals, row by row.

    Attributes:
        before: (V,) of the nominal robot.
        train: (V,) with effects fitted to everything.
        after: (V,) with effects fitted to the other folds.
        gain: of each fold, by how much half the chi-square falls.
        effects: of each fold, as fitted to the other folds.
    """

    before: Array
    train: Array
    after: Array
    gain: Array
    effects: tuple[tuple[Effect, ...], ...]


def held_out(nominal: Regression, refined: Refined) -> HeldOut:
    """Return the residuals of the nominal robot and of the effects, fitted with and without each fold.

    Events count as one parameter for each wheel: what a bump costs is learnt from the bumps of other
    laps, only its moment is taken from its own.

    Args:
        nominal: the recordings whitened about no effect, in the windows of `refined`.
        refined: the effects.
    """
    fitted = refined.regression
    before, train = nominal.white[:, 0], fitted.white[:, 0]
    after = train.copy()
    if not refined.terms:
        count = int(fitted.fold.max()) + 1
        return HeldOut(before, train, after, np.zeros(count), ((),) * count)
    columns, origin = _shared(refined)
    folds = range(int(fitted.fold.max()) + 1)
    effects = []
    for fold in folds:
        mine = fitted.fold == fold
        others = columns[~mine]
        # the base already holds the fit to everything; what other folds say is a step away from it
        target = fitted.white[~mine, 0] + others @ origin
        precision = others.T @ others + np.eye(columns.shape[1])
        known = np.linalg.solve(precision, others.T @ target)
        after[mine] = train[mine] - columns[mine] @ (known - origin)
        effects.append(_built(refined, known))
    gain = np.array(
        [
            0.5 * float((before[fitted.fold == one] ** 2 - after[fitted.fold == one] ** 2).sum())
            for one in folds
        ]
    )
    return HeldOut(before, train, after, gain, tuple(effects))


def _shared(refined: Refined) -> tuple[Array, Array]:
    """Return columns (V, k), all events of a wheel in one, and the coefficients (k,) of the base."""
    columns, origin = [], []
    for term, place, values in zip(refined.terms, refined.places, refined.values, strict=True):
        own = refined.regression.white[:, place]
        if term.linear == "lost" and own.shape[1] > 1:
            mean = float(values.mean())
            columns.append((own * (values / mean if abs(mean) > 1e-9 else np.ones_like(values))).sum(axis=1))
            origin.append(mean)
        else:
            columns += list(own.T)
            origin += values.tolist()
    return np.stack(columns, axis=1), np.array(origin)


def _built(refined: Refined, shared: Array) -> tuple[Effect, ...]:
    """Return the effects that shared coefficients (k,) stand for."""
    effects, at = [], 0
    for term, values in zip(refined.terms, refined.values, strict=True):
        if term.linear == "lost" and len(values) > 1:
            effects.append(term.built(np.full(len(values), shared[at])))
            at += 1
        else:
            effects.append(term.built(shared[at : at + len(values)]))
            at += len(values)
    return tuple(effects)


def size(rows: Array) -> float:
    """Return the root mean square of rows; 1.0 where there are none."""
    return float(np.sqrt(np.mean(rows**2))) if len(rows) else 1.0
