"""The evidence of recordings: residuals with their inverse covariance, and the effect of places on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.segments import CELL

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.fleet.report import BadPlace, PlaceEffect
    from omnimate.fleet.segments import Crossings, Segments
    from omnimate.vehicle.se2 import Array

FREEDOM: dict[PlaceEffect, int] = {"loss": 1, "creep": 2}  # components of an effect's size
Effects = dict[int, "Array"]  # effect of a place of unit size on the residuals, `(3 S, C)`, by recording


@dataclass(frozen=True, slots=True)
class Evidence:
    """The evidence of one recording on its robot and on the floor."""

    residual: Array  # all residuals, `(3 S,)`, as in `Segments`
    jacobian: Array  # their derivative by the robot's parameters, `(3 S, 3)`
    precision: Array  # their inverse covariance, `(3 S, 3 S)`
    # the precision with the robot's parameters projected out, so that wheel diameters and wheelbase do not
    # change the score of a place
    floor_precision: Array
    crossings: Crossings  # the cells that the segments cross

    def robot_information(self, effect: Array | float = 0.0) -> tuple[Array, Array]:
        """Return the Fisher information `(3, 3)` on the robot's parameters, and the score `(3,)`.

        The effect of the floor's places on the residuals, `(3 S,)`, is subtracted.
        """
        weighed = self.precision @ self.jacobian
        return self.jacobian.T @ weighed, weighed.T @ (self.residual - effect)

    def with_errors(self, errors: Sequence[Array]) -> Evidence:
        """Return the evidence with additional independent errors (Woodbury's identity).

        Each column of the arrays `(3 S, K)` is the effect of one error of one standard deviation.
        """
        if not errors:
            return self
        columns = np.concatenate(errors, axis=1)
        weighed = self.precision @ columns
        inner = np.eye(columns.shape[1]) + columns.T @ weighed
        precision = self.precision - weighed @ np.linalg.solve(inner, weighed.T)
        return replace(self, precision=precision, floor_precision=_project_out(precision, self.jacobian))


def weigh_segments(segments: Segments, crossings: Crossings, roughness: float) -> Evidence:
    """Return the evidence of a recording on a floor of a roughness [m/sqrt(m)]."""
    precision = np.linalg.inv(segments.covariance(roughness))
    precision = 0.5 * (precision + precision.T)
    jacobian = segments.jacobian.reshape(-1, 3)
    projected = _project_out(precision, jacobian)
    return Evidence(segments.residual.reshape(-1), jacobian, precision, projected, crossings)


def _project_out(precision: Array, jacobian: Array) -> Array:
    """Return a precision with the parameters of a Jacobian projected out."""
    weighed = precision @ jacobian
    return np.asarray(precision - weighed @ np.linalg.pinv(jacobian.T @ weighed) @ weighed.T, np.float64)


def fraction_inside(distance: Array, reach: float) -> Array:
    """Return the fraction of cells inside a disc of radius `reach` [m], by distance from its centre [m].

    It falls linearly from 1 to 0 over one cell.
    """
    return np.clip((reach - distance) / CELL + 0.5, 0.0, 1.0)


class FleetEvidence:
    """The evidence of many recordings, with a table of all their crossings.

    `initial` is the evidence of each recording, `recordings` the same with the errors added by `set_errors`.
    """

    def __init__(self, recordings: Sequence[Evidence]) -> None:
        self.recordings = self.initial = recordings
        self._effects: dict[tuple[str, float, float, float], Effects] = {}
        counts = [len(recording.crossings.segment) for recording in recordings]
        self._owner = np.repeat(np.arange(len(recordings)), counts)
        self._first = np.cumsum([0, *counts])
        self._cell = np.concatenate([recording.crossings.cell for recording in recordings]).astype(np.int32)

    def set_errors(self, errors: Mapping[int, Array]) -> None:
        """Replace the additional errors by these, `(3 S, K)` by recording (see `Evidence.with_errors`)."""
        self.recordings = [
            recording.with_errors([errors[number]]) if number in errors else recording
            for number, recording in enumerate(self.initial)
        ]

    def near(self, x: float, y: float, reach: float) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Yield recordings with crossings in the square of half side `reach` [m] around a point."""
        low = np.floor((np.array([x, y]) - reach) / CELL)
        high = np.ceil((np.array([x, y]) + reach) / CELL)
        along, across = self._cell[:, 0], self._cell[:, 1]
        inside = (along >= low[0]) & (along <= high[0])
        inside &= (across >= low[1]) & (across <= high[1])
        rows = np.flatnonzero(inside)
        owners, first = np.unique(self._owner[rows], return_index=True)
        for owner, part in zip(owners.tolist(), np.split(rows, first)[1:], strict=True):
            yield owner, part - self._first[owner]

    def effects_of(self, place: BadPlace) -> Effects:
        """Return the effect of a place of unit size on the residuals of the recordings that cross it."""
        key = place.effect, place.x, place.y, place.reach
        if key not in self._effects:
            self._effects[key] = dict(self._compute_effects(place))
        return self._effects[key]

    def _compute_effects(self, place: BadPlace) -> Iterator[tuple[int, Array]]:
        for number, rows in self.near(place.x, place.y, place.reach + CELL):
            crossings = self.recordings[number].crossings.rows(rows)
            from_place = CELL * crossings.cell - np.array([place.x, place.y])
            inside = fraction_inside(np.hypot(from_place[:, 0], from_place[:, 1]), place.reach)
            effect = np.zeros((len(self.recordings[number].residual) // 3, 3, FREEDOM[place.effect]))
            if place.effect == "loss":
                np.add.at(effect[:, :, 0], crossings.segment, inside[:, np.newaxis] * crossings.loss)
            else:
                for axis in range(2):
                    np.add.at(effect[:, axis, axis], crossings.segment, inside * crossings.creep)
            if effect.any():
                yield number, effect.reshape(-1, FREEDOM[place.effect])

    def sum_effects(self, places: Sequence[BadPlace]) -> list[Array]:
        """Return the effect of places of known sizes on the residuals of each recording, `(3 S,)`."""
        sums = [np.zeros(len(recording.residual)) for recording in self.recordings]
        for place in places:
            for number, effect in self.effects_of(place).items():
                sums[number] += effect @ place.size
        return sums
