"""Whitened columns of recordings: the data, and the change of the data by each candidate.

A column is the difference that a candidate makes when the recording is replayed with it, relative to a base
of effects; the same filter whitens the data and the columns.
"""

from __future__ import annotations

import copy
import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from omnimate.effects.ageing import AgedSamples, Younger
from omnimate.mismatch.noise.levels import filter_of
from omnimate.mismatch.noise.whitening import adjoint
from omnimate.mismatch.recording.response import brief_column, column, data, joined, moved_columns, response

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.noise.levels import Filter, NoiseLevels
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

Number = TypeVar("Number", np.float64, np.int64)

_CHUNK = 128  # columns that are whitened at once, to bound memory


@dataclass(slots=True)
class Regression:
    """Recordings whitened about a base of effects, with columns that grow as candidates come up."""

    windows: Sequence[Windows]  # linear model of each recording
    noise: NoiseLevels  # noise levels of the filters
    base: Sequence[Effect]  # effects about which it is linear
    # of each recording the inputs (M, 3 T, C) and measurements (M + 1, R, C) of columns that are kept; the
    # data come first
    raw: list[Columns] = field(init=False)
    responses: list[Columns] = field(init=False)  # of each recording to the base
    filters: list[Filter] = field(init=False)  # of each recording
    white: Array = field(init=False)  # whitened columns, in all rows that were measured, (V, C)
    owner: NDArray[np.int64] = field(init=False)  # recording of each row, (V,)
    moment: NDArray[np.int64] = field(init=False)  # window's end of each row, (V,)
    channel: NDArray[np.int64] = field(init=False)  # number of each row among the windows' rows, (V,)

    def __post_init__(self) -> None:
        self.responses = [response(windows, self.base) for windows in self.windows]
        self.raw = [data(windows, base) for windows, base in zip(self.windows, self.responses, strict=True)]
        self._whiten(self.windows)

    def with_noise(self, noise: NoiseLevels, windows: Sequence[Windows] | None = None) -> Regression:
        """Return the kept columns whitened with other noise levels, and other windows' process noise."""
        other = self.branch()
        other.noise = noise
        other._whiten(windows or self.windows)  # noqa: SLF001  its own
        return other

    def branch(self) -> Regression:
        """Return a regression with the same columns; what is added to either is not in the other."""
        return copy.copy(self)

    def _whiten(self, windows: Sequence[Windows]) -> None:
        self.filters = [filter_of(recording, self.noise) for recording in windows]
        places = [np.argwhere(np.isfinite(run.spread)) for run in self.filters]
        self.owner = np.repeat(np.arange(len(places)), [len(place) for place in places])
        self.moment, self.channel = np.concatenate(places).T
        self.white = self.whitened(self.raw)

    @property
    def time(self) -> Array:
        """Time of each row on its recording's clock, `(V,)` [s]."""
        return self.of_rows([windows.time for windows in self.windows])

    @property
    def window_count(self) -> int:
        """Number of windows' ends of all recordings: at so many moments something may begin."""
        return sum(len(windows.ends) for windows in self.windows)

    def of_rows(self, values: Sequence[NDArray[Number]]) -> NDArray[Number]:
        """Return for each row `(V,)` one of the values that each recording has at its windows' ends."""
        return np.concatenate(
            [of_recording[self.moment[self.rows_of(at)]] for at, of_recording in enumerate(values)]
        )

    def coefficients(self) -> Array:
        """Return the coefficients `(C - 1,)` of all columns that fit the data best."""
        columns = self.white[:, 1:]
        precision = columns.T @ columns + np.eye(columns.shape[1])
        return np.linalg.solve(precision, columns.T @ self.white[:, 0]).astype(np.float64)

    def residual(self, coefficients: Array | None = None) -> Array:
        """Return the residual `(V,)` of the data, by the best coefficients of all columns or by others."""
        known = self.coefficients() if coefficients is None else coefficients
        return np.asarray(self.white[:, 0] - self.white[:, 1:] @ known)

    def push_scores(self, rows: Array) -> list[tuple[Array, Array]]:
        """Return recordings' scores (M, n) and informations (M, n, n) of pushes in windows, by rows (V,)."""
        answers = []
        for number, (windows, run) in enumerate(zip(self.windows, self.filters, strict=True)):
            white = np.ascontiguousarray(rows[self.rows_of(number), None])
            scores, informations, _ = adjoint(
                run.transition, windows.links, windows.observe, run.gains, run.spread, white
            )
            answers.append((scores[:, :, 0], informations))
        return answers

    def lagged_rows(self, count: int) -> Array:
        """Return the data of each of c measured channels at lags of 1 to `count` windows, `(V, c count)`.

        They are regressors for autocorrelated noise, and for a robot that steers against its errors.
        """
        channels = self.windows[0].measured.shape[1]
        measured, place = np.unique(self.channel, return_inverse=True)
        lagged = np.zeros((len(self.owner), len(measured) * count))
        for number, windows in enumerate(self.windows):
            grid = np.zeros((len(windows.ends) + count, channels))
            rows = np.flatnonzero(self.owner == number)
            grid[self.moment[rows] + count, self.channel[rows]] = self.white[rows, 0]
            for lag in range(1, count + 1):
                column = place[rows] * count + lag - 1
                lagged[rows, column] = grid[self.moment[rows] + count - lag, self.channel[rows]]
        return lagged

    def whitened(self, raw: Sequence[Columns]) -> Array:
        """Return the measured rows (V, C) of columns, whitened."""
        width = raw[0][0].shape[2]
        white = np.empty((len(self.owner), width))
        for first in range(0, width, _CHUNK):
            chunk = slice(first, first + _CHUNK)
            for number, (run, (push, seen)) in enumerate(zip(self.filters, raw, strict=True)):
                white[self.rows_of(number), chunk] = run.whiten(push[:, :, chunk], seen[:, :, chunk])
        return white

    def whiten_travel(self, wheel: int, travel: Sequence[Array]) -> Array:
        """Return the whitened columns (V, C) of additional travel (M, C) of a wheel in each recording [m]."""
        parts = zip(self.filters, travel, strict=True)
        return np.vstack([run.whiten_travel(wheel, travel_of_part) for run, travel_of_part in parts])

    def rows_of(self, number: int) -> slice:
        """Return where the rows of a recording are."""
        return slice(*np.searchsorted(self.owner, (number, number + 1)).tolist())

    def use_secant(self, place: slice, effect: Effect, size: float) -> None:
        """Replace the column of an effect of the base by the secant from none of it, instead of the slope.

        Effects with a threshold, such as backlash, are not linear in their size. A delay is, and its slope is
        free of rounding; see `_column`. With the coefficient `size`, the column makes the effect.
        """
        if isinstance(effect, AgedSamples):
            return
        others = [other for other in self.base if other is not effect]
        parts = zip(self.responses, self.windows, strict=True)
        raw = [column(base, response(windows, others), -size) for base, windows in parts]
        self.white = self.white.copy()
        self.white[:, place] = self.whitened(raw)

    def append(self, columns: Array) -> slice:
        """Add whitened columns (V, C); return where they are."""
        first = self.white.shape[1]
        self.white = np.hstack([self.white, columns])
        return slice(first, self.white.shape[1])

    def shift_data(self, shift: Array | float) -> None:
        """Add whitened rows (V,) to the data."""
        self.white = np.column_stack([self.white[:, 0] + shift, self.white[:, 1:]])

    def columns_of(self, terms: Sequence[Term]) -> Array:
        """Return the whitened columns (V, C) of terms, one for each probe, without adding them."""
        return self.whitened(self._raw_of(terms))

    def _raw_of(self, terms: Sequence[Term]) -> list[Columns]:
        probes = [(probe, term.size) for term in terms for probe in term.probes]
        return [
            joined(
                [
                    moved_columns(windows, np.zeros((*windows.drift.shape, 0))),
                    *(self._column(number, probe, size) for probe, size in probes),
                ]
            )
            for number, windows in enumerate(self.windows)
        ]

    def _column(self, number: int, probe: Effect, size: float) -> Columns:
        """Return the column of a probe of a size, in one recording."""
        windows = self.windows[number]
        during = probe.acts_during(windows.signals.block)
        if during is not None:
            return brief_column(windows, self.base, probe, size, during)
        changed = response(windows, [*self.base, probe])
        if isinstance(probe, AgedSamples):
            # A difference to one side would hold the rounding of the samples themselves, which are also in
            # the data: delays of all channels at once would seem to explain rounding.
            return column(
                response(windows, [*self.base, Younger(probe.component, probe)]), changed, 2.0 * size
            )
        return column(self.responses[number], changed, size)

    def add(self, terms: Sequence[Term], *, keep: bool = True) -> list[slice]:
        """Add the columns of terms, kept by `with_noise` or not; return where each one's columns are."""
        return self.extend(self._raw_of(terms), [len(term.probes) for term in terms], keep=keep)

    def extend(self, raw: Sequence[Columns], widths: Sequence[int], *, keep: bool = True) -> list[slice]:
        """Add columns, inputs (M, 3 T, C) and measurements (M + 1, R, C) of each recording, in groups."""
        first = self.white.shape[1]
        if sum(widths):
            self.append(self.whitened(raw))
        if keep:
            self.raw = [joined(pair) for pair in zip(self.raw, raw, strict=True)]
        return slices_of(widths, first)


def slices_of(widths: Iterable[int], first: int = 0) -> list[slice]:
    """Return where groups of so many columns are that follow each other from the first column on."""
    edges = np.cumsum([first, *widths]).tolist()
    return [slice(start, end) for start, end in itertools.pairwise(edges)]
