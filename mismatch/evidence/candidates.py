"""Candidates with their columns in a regression, the background of every robot, and groups of its rows."""

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

SCORE_STRETCH = 4.0  # [s] over which scores are summed: long against the filter's memory of a model error
FURTHER_MISCALIBRATED = 0.3  # odds that a further number of a truck is wrong: it was not calibrated
FOLDS = 8  # of the data, held out in turn
# Log odds of a bump in one window of 0.25 s on a floor that has two of them already: once a minute, as robots
# come to a joint between slabs every ten or twenty metres.
BUMPS_OF_ROUGH_FLOOR, FURTHER_BUMP_LOG_ODDS = 2, math.log(1.0 / 240.0)


class CandidateGroup(NamedTuple):
    """Candidates with equal numbers of columns and of background columns, so that they can be stacked."""

    numbers: NDArray[np.int64]  # of the m candidates
    columns: NDArray[np.int64]  # their k columns, then s background columns of their effects, `(m, k + s)`
    sizes: Array  # standard deviations of the background coefficients, `(m, s)`
    nuisance_size: float  # size of each that any robot has at times, in declared sizes


@dataclass(slots=True)
class Candidates:
    """Candidates and the regression that judges them."""

    regression: Regression  # with the columns of all candidates
    terms: list[Term]  # the candidates
    places: list[slice]  # where each one's columns are
    background: tuple[NDArray[np.int64], Array]  # columns, and deviations [declared sizes], in every robot
    names: dict[int, tuple[str, str]]  # effect and component of each background column
    stretch: NDArray[np.int64] = field(init=False)  # number of each row's stretch of 4 s, `(V,)`
    fold: NDArray[np.int64] = field(init=False)  # number of each row's fold of the data, `(V,)`
    moments: NDArray[np.int64] = field(init=False)  # whether a second of a row is odd, `(V,)`
    moment: NDArray[np.int64] = field(init=False)  # number of the second of each row, `(V,)`
    second: NDArray[np.int64] = field(init=False)  # number of the second and channel of each row, `(V,)`
    background_places: dict[tuple[str, str], list[int]] = field(init=False)  # of its columns, by name

    def __post_init__(self) -> None:
        time, owner = self.regression.time, self.regression.owner
        starts = np.array([windows.time[0] for windows in self.regression.windows])
        spans = np.array([windows.time[-1] - windows.time[0] for windows in self.regression.windows])
        before = np.concatenate(([0.0], np.cumsum(spans)[:-1]))
        elapsed = time - starts[owner]
        along = elapsed + before[owner]  # the recordings end to end
        self.stretch = _numbered(owner, np.floor(elapsed / SCORE_STRETCH))
        self.fold = np.minimum((along / spans.sum() * FOLDS).astype(np.int64), FOLDS - 1)
        self.moment = _numbered(owner, np.floor(elapsed))
        self.second = _numbered(self.regression.channel, self.moment)
        self.moments = (np.floor(along).astype(np.int64)) % 2
        self.background_places = {}
        for place, column in enumerate(self.background[0].tolist()):
            self.background_places.setdefault(self.names[column], []).append(place)

    def odds(self, candidate: int, members: Iterable[int]) -> float:
        """Return the log prior odds of a candidate, given a set.

        If one of a truck's numbers is not calibrated, the others are likely not either; a floor with two
        bumps has more of them.
        """
        term = self.terms[candidate]
        if term.kind.scan == "moments" and len(term.fixed["times"]) == 1:
            others = [self.terms[other] for other in members if other != candidate]
            bumps = sum(len(other.fixed["times"]) for other in others if other.key == term.key)
            is_possible = term.odds > -math.inf
            if bumps >= BUMPS_OF_ROUGH_FLOOR and is_possible:
                return max(term.odds, FURTHER_BUMP_LOG_ODDS)
        if term.kind.calibrated and any(
            self.terms[other].kind.calibrated
            and self.terms[other].component.startswith(term.component[:1])
            and self.terms[other].key != term.key
            for other in members
        ):
            return term.odds + math.log(FURTHER_MISCALIBRATED / MISCALIBRATED)
        return term.odds

    def background_of(self, keys: set[tuple[str, str]]) -> tuple[NDArray[np.int64], Array]:
        """Return the background columns of some effects, and their standard deviations."""
        columns, sizes = self.background
        places = [place for key in sorted(keys) for place in self.background_places.get(key, ())]
        return columns[places], sizes[places]

    def columns(self, candidate: int) -> range:
        """Return the columns of a candidate."""
        return range(self.places[candidate].start, self.places[candidate].stop)

    def groups_of_equal_shape(self) -> list[CandidateGroup]:
        """Return all candidates in groups that can each be compared with nothing in one batch."""
        groups: dict[tuple[int, int, float], list[int]] = {}
        for candidate, term in enumerate(self.terms):
            shape = (
                len(self.columns(candidate)),
                len(self.background_places.get(term.key, ())),
                term.nuisance_size,
            )
            groups.setdefault(shape, []).append(candidate)
        result = []
        for (_, _, nuisance_size), members in groups.items():
            background = [self.background_of({self.terms[candidate].key}) for candidate in members]
            background_columns = [
                [*self.columns(candidate), *background_columns]
                for candidate, (background_columns, _) in zip(members, background, strict=True)
            ]
            result.append(
                CandidateGroup(
                    np.array(members),
                    np.array(background_columns, np.int64),
                    np.array([sizes for _, sizes in background]),
                    nuisance_size,
                )
            )
        return result


def _numbered(first: NDArray[np.int64], then: Array | NDArray[np.int64]) -> NDArray[np.int64]:
    """Return consecutive numbers (V,) for pairs of two whole numbers (V,), in their order."""
    then = then.astype(np.int64)
    _, number = np.unique(first * (int(then.max()) + 1) + then, return_inverse=True)
    return np.asarray(number, np.int64)
