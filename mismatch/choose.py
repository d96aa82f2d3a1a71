"""Which effects are in a recording: sets of terms compared by their evidence.

With coefficients of normal prior of precision D and white noise of size one, a set's log evidence is
b'(A + D)^-1 b / 2 - log det(A + D) / 2 + log det(D) / 2, with A and b the products of its columns with
each other and with the data (Bayes factor against no effect; the determinants are Occam's factor). An
effect is of the usual size (D = 1) or, less often, larger. Sets are grown, swapped and thinned until
nothing is better; the probability of a finding is the share of all sets that were compared which hold it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.terms import Term
    from omnimate.vehicle.se2 import Array

Set = frozenset[int]
EMPTY: Set = frozenset()

MOST = 6  # effects in one answer
EVENTS = {"bump", "slip_patch"}  # in whose place a push of the whole truck may stand
UNKNOWN_ODDS = 8.0  # log odds against every further unknown: one push shows in many places
LARGE = 2.0  # usual sizes beyond which an effect is taken for one of the rarer large ones
TAIL = 5.0  # usual sizes that a large one has
RARE = 1.6  # log odds against a large one
DOUBT = 2.5  # log odds against any one effect, beyond one among all candidates


@dataclass(slots=True)
class Choice:
    """Sets of terms and what they are worth.

    Attributes:
        terms: all candidates so far.
        places: where each one's columns are.
        total: (C, C) products of all columns, the data first.
        spread: by which the noise's squares are larger than they should be; 1 where it is as stated.
        known: log posterior of every set compared so far.
        repeats: whether a set may hold an effect and component twice.
    """

    terms: list[Term]
    places: list[slice]
    total: Array
    spread: float = 1.0
    known: dict[Set, float] = field(default_factory=dict)
    repeats: bool = False
    _names: float = field(init=False)

    def __post_init__(self) -> None:
        self._names = math.log(max(1, len({term.key for term in self.terms})))

    def columns(self, members: Iterable[int]) -> list[int]:
        """Return the columns of a set, in the order of its sorted members."""
        return [
            column
            for one in sorted(members)
            for column in range(self.places[one].start, self.places[one].stop)
        ]

    def solved(self, members: Iterable[int]) -> tuple[Array, Array]:
        """Return the coefficients `(k,)` of a set and their covariance `(k, k)`."""
        precision, coefficients, _ = self._posterior(members)
        return coefficients, np.asarray(np.linalg.inv(precision), np.float64)

    def explained(self, members: Iterable[int]) -> float:
        """Return how much of the sum of squares a set takes away."""
        columns, (coefficients, _) = self.columns(members), self.solved(members)
        products = self.total[np.ix_(columns, columns)]
        return float(2.0 * self.total[0, columns] @ coefficients - coefficients @ products @ coefficients)

    def _posterior(self, members: Iterable[int]) -> tuple[Array, Array, float]:
        """Return a set's precision `(k, k)`, coefficients `(k,)`, and what `tails` adds to the evidence."""
        columns, widths = self.columns(members), self._widths(members)
        own = self.total[columns, 0] / self.spread
        products = self.total[np.ix_(columns, columns)] / self.spread
        precision = products + np.eye(len(columns))
        coefficients = np.asarray(np.linalg.solve(precision, own), np.float64)
        scarce, prior = tails(coefficients, widths)
        if prior < 0.0:
            precision = products + np.diag(scarce)
            coefficients = np.asarray(np.linalg.solve(precision, own), np.float64)
        return precision, coefficients, prior

    def _widths(self, members: Iterable[int]) -> list[tuple[int, int]]:
        """Return how many coefficients are an effect's own, and how many more loosen its shape."""
        widths = []
        for one in sorted(members):
            whole = self.places[one].stop - self.places[one].start
            own = len(self.terms[one].probes) or whole
            widths.append((own, whole - own))
        return widths

    def worth(self, members: Set) -> float:
        """Return a set's log posterior, up to a constant; minus infinity where a coefficient has no sense."""
        if members not in self.known:
            self.known[members] = self._worth(members)
        return self.known[members]

    def _worth(self, members: Set) -> float:
        if not members:
            return 0.0
        keys = [self.terms[one].key for one in members]
        if (len(set(keys)) < len(keys) and not self.repeats) or self._twice(members):
            return -math.inf
        precision, coefficients, prior = self._posterior(members)
        if self._below_zero(members, coefficients):
            return -math.inf
        unknown = sum(self.terms[one].effect == "unknown" for one in members)
        evidence = (
            -UNKNOWN_ODDS * max(unknown - 1, 0)
            + 0.5 * float(coefficients @ precision @ coefficients)
            - 0.5 * float(np.linalg.slogdet(precision)[1])
            + prior
        )
        return evidence + sum(self.prior(one) for one in members)

    def _below_zero(self, members: Set, coefficients: Array) -> Set:
        """Return the members whose coefficients `(k,)` of the whole set make no sense."""
        found, at = set(), 0
        for one in sorted(members):
            term = self.terms[one]
            if term.positive and np.any(coefficients[at : at + len(term.probes)] < 0.0):
                found.add(one)
            at += self.places[one].stop - self.places[one].start
        return frozenset(found)

    def _absurd(self, members: Set) -> Set:
        """Return what must go first from a set of no worth: sizes below zero, or all that is in it."""
        return self._below_zero(members, self._posterior(members)[1]) or members

    def _twice(self, members: Set) -> bool:
        """Say whether a set holds an event of a truck and the push that stands in its place."""
        return any(
            self._replaces(one) and self.terms[other].component.startswith(self.terms[one].component)
            for one in members
            for other in members
            if self.terms[other].effect in EVENTS
        )

    def _replaces(self, one: int) -> bool:
        return "instead" in self.terms[one].fixed

    def _instead(self, members: Set) -> list[Set]:
        """Return sets in which one unknown takes the place of all that is on its truck, or of all but one.

        Named effects that together stand for something unknown cannot be left one by one.
        """
        moves: list[Set] = []
        for one, term in enumerate(self.terms):
            if term.effect == "unknown":
                truck = term.component.partition(".")[0]
                others = {own for own in members if not self.terms[own].component.startswith(truck)}
                events = {own for own in members if self.terms[own].effect in EVENTS}
                moves += [frozenset({one}), frozenset(others | {one}), members - events | {one}]
                moves += [frozenset({one, own}) for own in members]
        return moves

    def prior(self, one: int) -> float:
        """Return the log odds of a term before anything is seen."""
        return self.terms[one].plausibility - self._names - DOUBT

    def best(self, members: Set) -> Set:
        """Return the best set that growing, swapping and thinning lead to from a set."""
        everything, both = range(len(self.terms)), self._both()
        while members and self.worth(members) == -math.inf:
            members -= self._absurd(members)
        while True:
            moves = [members | {one} for one in everything if one not in members and len(members) < MOST]
            moves += [members - {one} for one in members]
            moves += [members - {old} | {new} for old in members for new in everything if new not in members]
            moves += [members | pair for pair in both if len(members | pair) <= MOST]
            moves += self._instead(members) if members else self._pairs()
            better = max(moves, key=self.worth, default=members)
            if self.worth(better) <= self.worth(members) + 1e-9:
                return members
            members = better

    def _both(self) -> list[Set]:
        """Return the pairs of an effect on truck a and the same on b: either alone is against the linkage."""
        trucks = [(number, one) for number, one in enumerate(self.terms) if one.component in {"a", "b"}]
        return [
            frozenset({first, second})
            for (first, one), (second, other) in combinations(trucks, 2)
            if one.effect == other.effect != "unknown"
            and one.component != other.component
            and one.fixed == other.fixed
        ]

    def _pairs(self) -> list[Set]:
        """Return the pairs of the likeliest terms, for effects that hide each other."""
        singles = sorted(range(len(self.terms)), key=lambda one: -self.worth(frozenset({one})))
        return [frozenset(pair) for pair in combinations(singles[:40], 2)]

    def probabilities(self) -> dict[Set, float]:
        """Return the posterior probabilities of all sets compared."""
        top = max(self.known.values())
        weights = {one: math.exp(value - top) for one, value in self.known.items() if value > top - 30.0}
        whole = sum(weights.values())
        return {one: weight / whole for one, weight in weights.items()}


def tails(coefficients: Array, widths: Sequence[tuple[int, int]]) -> tuple[Array, float]:
    """Return the precision (k,) of each coefficient's prior, and what the priors add to the log evidence.

    Args:
        coefficients: (k,) in usual sizes.
        widths: how many of them belong to each effect, and how many more to its shape, which has no tails.
    """
    scarce, added, at = np.ones(len(coefficients)), 0.0, 0
    for width, shape in widths:
        if float(np.abs(coefficients[at : at + width]).max(initial=0.0)) > LARGE:
            scarce[at : at + width] = TAIL**-2
            added -= RARE + width * math.log(TAIL)
        at += width + shape
    return scarce, added


def tolerant(total: Array, sizes: Array) -> Array:
    """Return products `(C, C)` for data in which every column also acts a little, unasked.

    Args:
        total: products of all columns, the data first.
        sizes: (C,) standard deviations of what is tolerated of each column; 0 for those that are not.
    """
    some = np.flatnonzero(sizes)
    across = total[:, some] * sizes[some]
    own = across[some] * sizes[some, None] + np.eye(len(some))
    return np.asarray(total - across @ np.linalg.solve(own, across.T))


def thinned(choice: Choice, members: Set) -> Set:
    """Return a set without the members that it is better off without."""
    while members:
        better = max((members - {one} for one in members), key=choice.worth)
        if choice.worth(better) <= choice.worth(members):
            break
        members = better
    return members


def inclusion(choice: Choice) -> dict[tuple[str, str], float]:
    """Return the probability of every effect on every component to be in the right set."""
    found: dict[tuple[str, str], float] = {}
    for members, probability in choice.probabilities().items():
        for key in {choice.terms[one].key for one in members}:
            found[key] = found.get(key, 0.0) + probability
    return found


def rivals(choice: Choice, chosen: Set, member: int) -> list[tuple[tuple[str, str], float]]:
    """Return what stands in a member's place in the sets that do without it, likeliest first."""
    own = choice.terms[member].key
    rest = {choice.terms[one].key for one in chosen} - {own}
    found: dict[tuple[str, str], float] = {}
    for members, probability in choice.probabilities().items():
        keys = {choice.terms[one].key for one in members}
        if own in keys:
            continue
        for key in keys - rest:
            found[key] = found.get(key, 0.0) + probability
    return sorted(found.items(), key=lambda item: -item[1])


def decoded(choice: Choice, chosen: Sequence[int] | Set) -> list[tuple[int, Array, Array]]:
    """Return of each member its number, coefficients and their covariance, in sorted order."""
    coefficients, covariance = choice.solved(chosen)
    found, at = [], 0
    for one in sorted(chosen):
        width = choice.places[one].stop - choice.places[one].start
        own = slice(at, at + width)
        found.append((one, coefficients[own], covariance[own, own]))
        at += width
    return found
