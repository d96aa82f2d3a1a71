"""Candidates, and the recordings that judge them: columns, everyday sizes, and parts of the rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.effects.effect import MISCALIBRATED

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.vehicle.se2 import Array

STRETCH = 4.0  # [s] in which scores are summed: long against what a filter remembers of a wrong model
# Odds that another number of a truck is wrong, too, if one is: the truck was not calibrated.
UNCALIBRATED = 0.3
FOLDS = 8  # into which data are cut to be held out in turn
# Log odds of a bump in one window of 0.25 s on a floor that has two of them already: once a minute, as robots
# come to a joint between slabs every ten or twenty metres.
MANY, AGAIN = 2, math.log(1.0 / 240.0)


class Alike(NamedTuple):
    """Candidates that have as many columns, and as many everyday ones of their names.

    Attributes:
        numbers: Of the m candidates.
        columns: Theirs, and then the everyday ones, `(m, k + s)`.
        sizes: Of the everyday ones, `(m, s)`.
        ordinary: What any robot meets of each of them at some moment, in declared sizes.
    """

    numbers: NDArray[np.int64]
    columns: NDArray[np.int64]
    sizes: Array
    ordinary: float


@dataclass(slots=True)
class Candidates:
    """Candidates and the recordings that judge them.

    Attributes:
        regression: With the columns of all candidates.
        terms: The candidates.
        places: Where each one's columns are.
        everyday: Columns of which every robot has a little, and how much, in declared sizes.
        names: What each everyday column is called.
        stretch: Number of each row's stretch of 4 s, `(V,)`.
        fold: Number of each row's fold of the data, `(V,)`.
        moments: Whether a second of a row is odd, `(V,)`.
        moment: Number of the second of each row, `(V,)`.
        second: Number of the second and channel of each row, `(V,)`.
        called: Places of everyday columns by their names.
    """

    regression: Regression
    terms: list[Term]
    places: list[slice]
    everyday: tuple[NDArray[np.int64], Array]
    names: dict[int, tuple[str, str]]
    stretch: NDArray[np.int64] = field(init=False)
    fold: NDArray[np.int64] = field(init=False)
    moments: NDArray[np.int64] = field(init=False)
    moment: NDArray[np.int64] = field(init=False)
    second: NDArray[np.int64] = field(init=False)
    called: dict[tuple[str, str], list[int]] = field(init=False)

    def __post_init__(self) -> None:
        time, owner = self.regression.time, self.regression.owner
        starts = np.array([single.time[0] for single in self.regression.windows])
        spans = np.array([single.time[-1] - single.time[0] for single in self.regression.windows])
        before = np.concatenate(([0.0], np.cumsum(spans)[:-1]))
        since = time - starts[owner]
        along = since + before[owner]  # the recordings end to end
        self.stretch = _numbered(owner, np.floor(since / STRETCH))
        self.fold = np.minimum((along / spans.sum() * FOLDS).astype(np.int64), FOLDS - 1)
        self.moment = _numbered(owner, np.floor(since))
        self.second = _numbered(self.regression.channel, self.moment)
        self.moments = (np.floor(along).astype(np.int64)) % 2
        self.called = {}
        for place, column in enumerate(self.everyday[0].tolist()):
            self.called.setdefault(self.names[column], []).append(place)

    def odds(self, single: int, members: Iterable[int]) -> float:
        """Return the log prior odds of a candidate beside a set.

        Whoever has not calibrated one of a truck's numbers has not calibrated the others, and a floor on
        which a wheel met two bumps has more of them.
        """
        term = self.terms[single]
        if term.scan == "moments" and len(term.fixed["times"]) == 1:
            others = [self.terms[other] for other in members if other != single]
            bumps = sum(len(other.fixed["times"]) for other in others if other.key == term.key)
            if bumps >= MANY:
                return max(term.odds, AGAIN)
        if term.is_calibrated and any(
            self.terms[other].is_calibrated
            and self.terms[other].component.startswith(term.component[:1])
            and self.terms[other].key != term.key
            for other in members
        ):
            return term.odds + math.log(UNCALIBRATED / MISCALIBRATED)
        return term.odds

    def same(self, keys: set[tuple[str, str]]) -> tuple[NDArray[np.int64], Array]:
        """Return the everyday columns of what has one of some names, and their sizes."""
        everyday, sizes = self.everyday
        mine = [place for key in sorted(keys) for place in self.called.get(key, ())]
        return everyday[mine], sizes[mine]

    def columns(self, single: int) -> range:
        """Return the columns of a candidate."""
        return range(self.places[single].start, self.places[single].stop)

    def alike(self) -> list[Alike]:
        """Return all candidates in groups of which each can be compared with nothing at once."""
        groups: dict[tuple[int, int, float], list[int]] = {}
        for single, term in enumerate(self.terms):
            shape = len(self.columns(single)), len(self.called.get(term.key, ())), term.ordinary
            groups.setdefault(shape, []).append(single)
        found = []
        for (_, _, ordinary), mine in groups.items():
            same = [self.same({self.terms[single].key}) for single in mine]
            columns = [
                [*self.columns(single), *columns] for single, (columns, _) in zip(mine, same, strict=True)
            ]
            found.append(
                Alike(
                    np.array(mine),
                    np.array(columns, np.int64),
                    np.array([sizes for _, sizes in same]),
                    ordinary,
                )
            )
        return found


def _numbered(first: NDArray[np.int64], then: Array | NDArray[np.int64]) -> NDArray[np.int64]:
    """Return consecutive numbers (V,) for pairs of two whole numbers (V,), in their order."""
    then = then.astype(np.int64)
    _, number = np.unique(first * (int(then.max()) + 1) + then, return_inverse=True)
    return np.asarray(number, np.int64)
