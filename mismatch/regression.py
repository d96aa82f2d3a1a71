"""Whitened columns of recordings, as sums over stretches that may be held out.

Every choice between models needs only the products of columns with each other: they are added up
once, by fold, and any set of terms is then a small matrix.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.model import column, data, response
from omnimate.mismatch.noise import filter_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.model import Columns, Response
    from omnimate.mismatch.noise import Filter, NoiseLevels
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.se2 import Array


_CHUNK = 128  # columns that are whitened at once


@dataclass(slots=True)
class Regression:
    """Recordings whitened about a base of effects, with columns that grow as candidates come up.

    Attributes:
        windows: of each recording.
        noise: its levels.
        base: effects about which it is linear.
        folds: of each recording (M + 1,) the number of the stretch that each window belongs to.
        raw: of each recording the columns' inputs (M, 3 T, C) and measurements (M + 1, R, C); the data
            come first.
        filters: of each recording the filter's gains and the innovations' variances.
        white: (V, C) whitened columns, in all rows that were measured.
        owner: (V,) recording of each row.
        moment: (V,) window's end of each row.
        channel: (V,) its number among the windows' rows.
        fold: (V,) stretch of each row.
        products: (folds, C, C) products of all columns.
    """

    windows: Sequence[Windows]
    noise: NoiseLevels
    base: Sequence[Effect]
    folds: Sequence[NDArray[np.int64]]
    raw: list[Columns] = field(init=False)
    responses: list[Response] = field(init=False)
    filters: list[Filter] = field(init=False)
    white: Array = field(init=False)
    owner: NDArray[np.int64] = field(init=False)
    moment: NDArray[np.int64] = field(init=False)
    channel: NDArray[np.int64] = field(init=False)
    fold: NDArray[np.int64] = field(init=False)
    products: Array = field(init=False)

    def __post_init__(self) -> None:
        self.responses = [response(one, self.base) for one in self.windows]
        data_columns = [data(one, base) for one, base in zip(self.windows, self.responses, strict=True)]
        self.raw = [(push[:, :, None], seen[:, :, None]) for push, seen in data_columns]
        self.whiten(self.noise)

    def whiten(self, noise: NoiseLevels) -> None:
        """Whiten all columns anew with other levels of noise."""
        self.noise = noise
        self.filter([filter_of(one, noise) for one in self.windows])

    def filter(self, filters: Sequence[Filter]) -> None:
        """Send all columns through other filters, one for each recording."""
        self.filters = list(filters)
        places = [np.argwhere(np.isfinite(run.spread)) for run in self.filters]
        self.owner = np.repeat(np.arange(len(places)), [len(one) for one in places])
        self.moment, self.channel = np.concatenate(places).T
        self.fold = np.concatenate([own[one[:, 0]] for own, one in zip(self.folds, places, strict=True)])
        self.white = self.rows([run.whiten(*raw) for run, raw in zip(self.filters, self.raw, strict=True)])
        self._multiply()

    def rows(self, white: Sequence[Array]) -> Array:
        """Return the measured rows (V, C) of whitened columns (M + 1, R, C) of each recording."""
        parts = []
        for number, own in enumerate(white):
            mine = self.owner == number
            parts.append(own[self.moment[mine], self.channel[mine]])
        return np.concatenate(parts)

    def _multiply(self, first: int = 0) -> None:
        """Multiply all columns from one on with all; the products of those before are known."""
        count, width = int(self.fold.max()) + 1, self.white.shape[1]
        products = np.empty((count, width, width))
        products[:, :first, :first] = self.products[:, :first, :first] if first else 0.0
        for one in range(count):
            mine = self.white[self.fold == one]
            across = mine.T @ mine[:, first:]
            products[one, :, first:], products[one, first:] = across, across.T
        self.products = products

    @property
    def total(self) -> Array:
        """Products of all columns over all folds, `(C, C)`."""
        return np.asarray(self.products.sum(axis=0))

    def add(self, terms: Sequence[Term]) -> list[slice]:
        """Add the columns of terms; return where each one's columns are."""
        places, at = [], self.white.shape[1]
        for one in terms:
            places.append(slice(at, at + len(one.probes)))
            at += len(one.probes)
        probes = [(probe, one.size) for one in terms for probe in one.probes]
        self.extend(
            [
                [column(base, response(windows, [*self.base, probe]), size) for probe, size in probes]
                for windows, base in zip(self.windows, self.responses, strict=True)
            ]
        )
        return places

    def extend(self, columns: Sequence[Sequence[Columns]]) -> slice:
        """Add columns, each inputs (M, 3 T) and measurements (M + 1, R), of each recording."""
        before = self.white.shape[1]
        if not columns[0]:
            return slice(before, before)
        for number, own in enumerate(columns):
            old_push, old_seen = self.raw[number]
            push = np.empty((*old_push.shape[:2], before + len(own)))
            seen = np.empty((*old_seen.shape[:2], before + len(own)))
            push[:, :, :before], seen[:, :, :before] = old_push, old_seen
            for at, (inputs, measured) in enumerate(own, before):
                push[:, :, at], seen[:, :, at] = inputs, measured
            self.raw[number] = push, seen
        width = self.raw[0][0].shape[2]
        white = np.empty((len(self.white), width))
        white[:, :before] = self.white
        for first in range(before, width, _CHUNK):
            some = slice(first, first + _CHUNK)
            white[:, some] = self.rows(
                [
                    one.whiten(push[:, :, some], seen[:, :, some])
                    for one, (push, seen) in zip(self.filters, self.raw, strict=True)
                ]
            )
        self.white = white
        self._multiply(before)
        return slice(before, width)

    def bare(self) -> Regression:
        """Return the same without any columns but the data, to which others may be added."""
        found = copy(self)
        found.drop(1)
        return found

    def drop(self, first: int) -> None:
        """Forget all columns from one on."""
        self.raw = [(push[:, :, :first], seen[:, :, :first]) for push, seen in self.raw]
        self.white = self.white[:, :first]
        self.products = self.products[:, :first, :first]

    def replace(self, place: slice, by: slice) -> None:
        """Let columns stand in the place of others, of which there are as many."""
        for push, seen in self.raw:
            push[:, :, place], seen[:, :, place] = push[:, :, by], seen[:, :, by]
        self.white[:, place] = self.white[:, by]
        self._multiply()
