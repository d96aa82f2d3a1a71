"""From the linear search to the effects themselves: their parameters by Gauss-Newton."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.evidence.posterior import LARGEST
from omnimate.mismatch.recording.response import relinearised
from omnimate.mismatch.recording.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

TURNS = 2  # the effects are small, and the second turn changes them by their square


@dataclass(frozen=True, slots=True)
class Fitted:
    """Effects as they fit best.

    Attributes:
        terms: One for each effect, with what is not linear as found.
        values: Coefficients of each term, `(k,)`.
        effects: The effects that these are.
        regression: About the effects, with the terms' columns.
        places: Of the columns.
        covariance: Of all coefficients, `(K, K)`.
    """

    terms: tuple[Term, ...]
    values: tuple[Array, ...]
    effects: tuple[Effect, ...]
    regression: Regression
    places: tuple[slice, ...]
    covariance: Array

    @property
    def part(self) -> Array:
        """What of the data the effects explain, `(V,)`, whitened."""
        white = self.regression.white
        part = np.zeros(len(white))
        for place, values in zip(self.places, self.values, strict=True):
            part += white[:, place] @ values
        return part

    def covariances(self) -> list[Array]:
        """Return the covariance of each term's coefficients."""
        first = 0
        found = []
        for values in self.values:
            own = slice(first, first + len(values))
            found.append(self.covariance[own, own])
            first += len(values)
        return found


def fitted(
    signals: Sequence[Signals],
    noise: NoiseLevels,
    terms: Sequence[Term],
    values: Sequence[Array],
    turns: int = TURNS,
) -> Fitted:
    """Return terms with their coefficients fitted, each turn about what the last one found.

    Args:
        signals: Of each recording, about the nominal robot.
        noise: Levels of noise.
        terms: To fit.
        values: Of their coefficients, from which to start.
        turns: Of Gauss-Newton; with none the effects stay as they are.
    """
    terms, values = [single.fine() for single in terms], list(values)
    for turn in range(turns + 1):
        effects = tuple(single.built(own) for single, own in zip(terms, values, strict=True))
        windows = [windows_of(relinearised(single, effects)) for single in signals]
        regression = Regression(windows, noise, effects)
        places = tuple(regression.add(terms))
        columns = regression.white[:, 1:]
        precision = columns.T @ columns + np.eye(columns.shape[1]) / LARGEST**2
        if turn == turns:
            break
        known = np.concatenate([np.zeros(0), *values])
        slope = columns.T @ regression.white[:, 0] - known / LARGEST**2
        known = known + np.linalg.solve(precision, slope)
        for number, place in enumerate(places):
            values[number] = known[place.start - 1 : place.stop - 1]
            if terms[number].positive:
                values[number] = np.maximum(values[number], 0.0)
    return Fitted(
        tuple(terms), tuple(values), effects, regression, places, np.linalg.inv(precision).astype(np.float64)
    )
