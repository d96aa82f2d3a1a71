"""Whitened columns of recordings: the data, and what each candidate would add to them.

A column is the difference that a candidate makes when the recording is replayed with it, beyond a base of
effects that are known already; the filter that makes the data's noise white goes over both.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.noise.levels import filter_of
from omnimate.mismatch.noise.whitening import adjoint
from omnimate.mismatch.recording.response import brief_column, column, data, response

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.noise.levels import Filter, NoiseLevels
    from omnimate.mismatch.recording.response import Columns, Response
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

_CHUNK = 128  # columns that are whitened at once


@dataclass(slots=True)
class Regression:
    """Recordings whitened about a base of effects, with columns that grow as candidates come up.

    Attributes:
        windows: Linear model of each recording.
        noise: Its levels.
        base: Effects about which it is linear.
        raw: Of each recording the inputs (M, 3 T, C) and measurements (M + 1, R, C) of columns that are kept;
            the data come first.
        filters: Of each recording the filter's gains and the innovations' variances.
        white: Whitened columns, in all rows that were measured, (V, C).
        owner: Recording of each row, (V,).
        moment: Window's end of each row, (V,).
        channel: Number of each row among the windows' rows, (V,).
    """

    windows: Sequence[Windows]
    noise: NoiseLevels
    base: Sequence[Effect]
    raw: list[Columns] = field(init=False)
    responses: list[Response] = field(init=False)
    filters: list[Filter] = field(init=False)
    white: Array = field(init=False)
    owner: NDArray[np.int64] = field(init=False)
    moment: NDArray[np.int64] = field(init=False)
    channel: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        self.responses = [response(single, self.base) for single in self.windows]
        columns = [data(single, base) for single, base in zip(self.windows, self.responses, strict=True)]
        self.raw = [(push[:, :, None], seen[:, :, None]) for push, seen in columns]
        self.whiten(self.noise)

    def whiten(self, noise: NoiseLevels, windows: Sequence[Windows] | None = None) -> None:
        """Whiten all columns anew with other levels of noise, and other windows' process noise."""
        self.noise = noise
        self.filters = [filter_of(single, noise) for single in (windows or self.windows)]
        places = [np.argwhere(np.isfinite(run.spread)) for run in self.filters]
        self.owner = np.repeat(np.arange(len(places)), [len(place) for place in places])
        self.moment, self.channel = np.concatenate(places).T
        self.white = self.whitened(self.raw)

    @property
    def time(self) -> Array:
        """Time of each row on its recording's clock, `(V,)` [s]."""
        moments = [single.time for single in self.windows]
        return np.array([moments[owner][at] for owner, at in zip(self.owner, self.moment, strict=True)])

    def sizes(self) -> Array:
        """Return the coefficients `(C - 1,)` of all columns that fit the data best."""
        columns = self.white[:, 1:]
        precision = columns.T @ columns + np.eye(columns.shape[1])
        return np.linalg.solve(precision, columns.T @ self.white[:, 0]).astype(np.float64)

    def without(self, sizes: Array) -> Array:
        """Return the data's rows `(V,)` without all columns, by their coefficients."""
        return np.asarray(self.white[:, 0] - self.white[:, 1:] @ sizes)

    def shocks(self, rows: Array) -> list[tuple[Array, Array]]:
        """Return of each recording the scores (M, n) and informations (M, n, n) of a push in each window.

        Args:
            rows: Whitened rows of what is left of the data, `(V,)`.
        """
        answers = []
        for number, (windows, run) in enumerate(zip(self.windows, self.filters, strict=True)):
            white = np.ascontiguousarray(rows[self.rows_of(number), None])
            scores, informations, _ = adjoint(
                run.transition, windows.links, windows.observe, run.gains, run.spread, white
            )
            answers.append((scores[:, :, 0], informations))
        return answers

    def echoes(self, count: int) -> Array:
        """Return the data's rows of each of c measured channels again, some windows later, `(V, c count)`.

        They are what noise that is not quite white, and a robot that steers against its errors, make of them.

        Args:
            count: Windows by which the rows are late, 1 to so many.
        """
        channels = self.windows[0].measured.shape[1]
        measured, place = np.unique(self.channel, return_inverse=True)
        found = np.zeros((len(self.owner), len(measured) * count))
        for number, windows in enumerate(self.windows):
            grid = np.zeros((len(windows.ends) + count, channels))
            mine = np.flatnonzero(self.owner == number)
            grid[self.moment[mine] + count, self.channel[mine]] = self.white[mine, 0]
            for late in range(1, count + 1):
                column = place[mine] * count + late - 1
                found[mine, column] = grid[self.moment[mine] + count - late, self.channel[mine]]
        return found

    def whitened(self, raw: Sequence[Columns]) -> Array:
        """Return the measured rows (V, C) of columns, whitened."""
        width = raw[0][0].shape[2]
        white = np.empty((len(self.owner), width))
        for first in range(0, width, _CHUNK):
            some = slice(first, first + _CHUNK)
            for number, (run, (push, seen)) in enumerate(zip(self.filters, raw, strict=True)):
                white[self.rows_of(number), some] = run.whiten(push[:, :, some], seen[:, :, some])
        return white

    def of_ways(self, wheel: int, ways: Sequence[Array]) -> Array:
        """Return the whitened columns (V, C) of ways (M, C) that a wheel gains in each recording [m]."""
        return np.vstack([run.whiten_ways(wheel, own) for run, own in zip(self.filters, ways, strict=True)])

    def rows_of(self, number: int) -> slice:
        """Return where the rows of a recording are."""
        return slice(*np.searchsorted(self.owner, (number, number + 1)).tolist())

    def take_secant(self, place: slice, effect: Effect, size: float) -> None:
        """Let a column be what an effect of the base does, over its size, in the place of its slope there.

        A play of half the width is no play half as strong.

        Args:
            place: Of the column.
            effect: Of the base.
            size: Coefficient of the column that makes the effect.
        """
        others = [single for single in self.base if single is not effect]
        raw = []
        for base, windows, (pushes, measured) in zip(self.responses, self.windows, self.raw, strict=True):
            push, seen = column(base, response(windows, others), -size)
            pushes[:, :, place.start], measured[:, :, place.start] = push, seen
            raw.append((push[:, :, None], seen[:, :, None]))
        self.white[:, place] = self.whitened(raw)

    def columns_of(self, terms: Sequence[Term]) -> Array:
        """Return the whitened columns (V, C) of terms, one for each probe; nothing is kept."""
        return self.whitened(self._raw_of(terms))

    def _raw_of(self, terms: Sequence[Term]) -> list[Columns]:
        probes = [(probe, single.size) for single in terms for probe in single.probes]
        return [
            _stacked([self._column(number, probe, size) for probe, size in probes], windows)
            for number, windows in enumerate(self.windows)
        ]

    def _column(self, number: int, probe: Effect, size: float) -> Columns:
        """Return the column of a probe of a size, in one recording."""
        windows = self.windows[number]
        during = probe.acts_during(windows.signals.block)
        if during is not None:
            return brief_column(windows, self.base, probe, size, during)
        return column(self.responses[number], response(windows, [*self.base, probe]), size)

    def add(self, terms: Sequence[Term], *, keep: bool = True) -> list[slice]:
        """Add the columns of terms; return where each one's columns are.

        Args:
            terms: Of them.
            keep: Whether they are whitened anew with other levels of noise.
        """
        return self.extend(self._raw_of(terms), [len(single.probes) for single in terms], keep=keep)

    def extend(self, raw: Sequence[Columns], widths: Sequence[int], *, keep: bool = True) -> list[slice]:
        """Add columns, inputs (M, 3 T, C) and measurements (M + 1, R, C) of each recording, in groups."""
        first = self.white.shape[1]
        edges = first + np.concatenate(([0], np.cumsum(widths))).astype(int)
        if edges[-1] > first:
            self.white = np.hstack([self.white, self.whitened(raw)])
        if keep:
            self.raw = [
                (np.concatenate((push, more), axis=2), np.concatenate((seen, other), axis=2))
                for (push, seen), (more, other) in zip(self.raw, raw, strict=True)
            ]
        return [slice(start, end) for start, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]


def _stacked(pairs: Sequence[Columns], windows: Windows) -> Columns:
    """Return columns side by side: inputs (M, 3 T, C) and measurements (M + 1, R, C)."""
    if not pairs:
        return np.zeros((*windows.drift.shape, 0)), np.zeros((*windows.measured.shape, 0))
    return np.stack([push for push, _ in pairs], axis=2), np.stack([seen for _, seen in pairs], axis=2)
