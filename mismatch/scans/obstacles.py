"""Obstacles that are met many times, told before anything else is looked for.

A wheel that climbs over an obstacle loses way; but it also shakes the robot while it climbs, sways it on
its tyres and pulls at the linkage, and nobody knows how. On a smooth floor that is many times what noise is,
and a search that adds event after event explains it by whatever fits. What each obstacle leaves behind is
clear all the same: where the truck stands then. So windows in which something happened are gathered into
encounters, and each is compared as a whole: a wheel lost way there, and the trucks were shaken to and fro
beside it; or it was anything else. Under which wheels obstacles are is a mixture over all encounters.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import log_ndtr

from omnimate.effects import effects_scanned_by
from omnimate.effects.block import wheel_radius
from omnimate.effects.crossing import losing
from omnimate.effects.effect import WHEEL
from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.evidence.density import FAULT_SIZE_MIXTURE, log_evidence
from omnimate.mismatch.noise.levels import estimate_noise
from omnimate.mismatch.noise.whitening import whiten
from omnimate.mismatch.recording.signals import WINDOW
from omnimate.mismatch.scans.disturbances import SHOVE, freed
from omnimate.mismatch.scans.events import travelled
from omnimate.mismatch.scans.nonlinear import SHORTEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

ENCOUNTERS = 6  # encounters, from which they are told together: fewer are found one by one
GAP = 2  # windows between two encounters: a slow wheel takes half a second to pass an obstacle
AFTER = 8  # windows after an encounter that still show it
LONGEST = 24  # windows of an encounter: what goes on longer is none
TURNS = 4  # of what stands out of noise, and of noise beside it
SHAKEN = (0.15, 0.3, 0.6, 1.2)  # parts of what obstacles do for good, by which they also shake a robot
PARTS = 8  # of a window, to which the begin of a crossing is told
SUREST = 200.0  # log odds
STILL = 0.01  # [m/s] below which a wheel comes to a stand, or reverses


@dataclass(frozen=True, slots=True)
class Train(Term):
    """All obstacles under one wheel as a candidate of one column, with what each takes of all being known.

    Attributes:
        shares: What each of them takes, in that of all on average, `(K,)`.
        mean: What they take on average, in declared sizes.
    """

    shares: tuple[float, ...] = ()
    mean: float = 1.0

    def built(self, coefficients: Array) -> Effect:
        """Return the obstacles with this coefficient `(1,)`."""
        lost = np.maximum(float(coefficients[0]), 0.0) * LOST * np.array(self.shares)
        return _of(self.component, self.fixed["times"], lost)

    @property
    def held(self) -> float:
        """Its size: what shakes the robot meanwhile, and is gone then, would be taken for a part of that."""
        return self.mean

    def at(self, **fixed: Any) -> Term:  # noqa: ANN401
        """Return the obstacles at other moments."""
        times = tuple(fixed["times"])
        return train(self.component, times, self.shares, self.mean, self.odds)


OBSTACLE = effects_scanned_by("moments", WHEEL[0])[0]
SLIP = effects_scanned_by("interval", WHEEL[0])[0].estimated().scale
LOST = OBSTACLE.estimated().scale


def _of(wheel: str, times: tuple[float, ...], lost: Array) -> Effect:
    """Return obstacles under a wheel that take lengths `(n,)` [m] at times [s]."""
    values: dict[str, Any] = {"times": times, OBSTACLE.linear: tuple(lost.tolist())}
    return OBSTACLE(component=wheel, **values)


def train(wheel: str, times: tuple[float, ...], shares: tuple[float, ...], mean: float, odds: float) -> Train:
    """Return the candidate of obstacles under one wheel.

    Args:
        wheel: Under which they are.
        times: When each crossing begins [s], in order.
        shares: What each takes of what all take on average.
        mean: What they take on average, in declared sizes.
        odds: Log odds that they are there.
    """
    probe = _of(wheel, times, LOST * np.array(shares))
    fixed = {"times": times}
    return Train(OBSTACLE.name, wheel, (probe,), fixed, odds, positive=True, shares=shares, mean=mean)


@dataclass(frozen=True, slots=True)
class Obstacles:
    """What was met many times.

    Attributes:
        terms: Obstacles under each wheel that met some.
        pushes: Of each recording process covariances `(M, n, n)` by which encounters shake the robot.
    """

    terms: list[Train]
    pushes: list[Array]

    @property
    def values(self) -> list[Array]:
        """Their coefficients."""
        return [np.array([single.held]) for single in self.terms]


@dataclass(frozen=True, slots=True)
class _Encounter:
    """A stretch of windows in which something happened.

    Attributes:
        number: Of the recording.
        windows: Of it.
        stretch: Of its windows.
        ways: Way of each wheel in each of these, `(n, W)` [m].
        gram: Products of the columns of pushes (n 3 T) in each of them with each other.
        score: Products with what is left of the data.
    """

    number: int
    windows: Windows
    stretch: range
    ways: Array
    gram: Array
    score: Array

    def evidence(self, pushes: Array) -> float:
        """Return the log evidence of pushes of which this is a root of the covariance, `(n 3 T, k)`."""
        return float(log_evidence(pushes.T @ self.gram @ pushes, pushes.T @ self.score, 1.0))

    def given(self, pushes: Array) -> tuple[Array, Array]:
        """Return gram and score with some pushes, likewise a root, being noise."""
        inside = self.gram @ pushes
        precision = pushes.T @ inside + np.eye(pushes.shape[1])
        taken = np.linalg.solve(precision, np.column_stack([inside.T, pushes.T @ self.score]))
        return self.gram - inside @ taken[:, :-1], self.score - inside @ taken[:, -1]


@dataclass(frozen=True, slots=True)
class _Crossing:
    """What an encounter is if a wheel met an obstacle there.

    Attributes:
        evidence: Log Bayes factor against nothing.
        begin: When it begins [s].
        lost: Way that is lost [m].
    """

    evidence: float = -math.inf
    begin: float = 0.0
    lost: float = 0.0


def obstacles(regression: Regression) -> Obstacles:
    """Return the obstacles that wheels met many times.

    Args:
        regression: Of the nominal robot, with the columns of what may be wrong with any robot, whitened by
            the noise of such a robot. It is whitened anew.
    """
    told = no_obstacles(regression)
    found = _encounters(regression)
    if len(found) < ENCOUNTERS:
        return told
    wheels = [str(wheel) for wheel in regression.windows[0].signals.recording.vehicle.wheels]
    every = [_crossings(found, shaken) for shaken in SHAKEN]
    other = np.array([_otherwise(single) for single in found])
    tables = [np.array([[its.evidence for its in row] for row in crossings]) for crossings in every]
    mixtures = [_mixtures(table, other) for table in tables]
    best = max(range(len(SHAKEN)), key=lambda at: mixtures[at][0])
    _, odds, shares = mixtures[best]
    for at, wheel in enumerate(wheels):
        crossings = [
            (single, _refined(single, at, SHAKEN[best], row[at]))
            for single, row, share in zip(found, every[best], shares[:, at], strict=True)
            if share > 0.5
        ]
        crossings = [(single, its) for single, its in crossings if its.lost > 0.0]
        if odds[at] <= 0.0 or len(crossings) < ENCOUNTERS:
            continue
        mean = float(np.mean([its.lost for _, its in crossings]))
        times = tuple(its.begin for _, its in crossings)
        parts = tuple(its.lost / mean for _, its in crossings)
        told.terms.append(train(wheel, times, parts, mean / LOST, min(SUREST, odds[at])))
        for single, its in crossings:
            sizes = np.diag((SHAKEN[best] * its.lost * _shapes(single.windows)) ** 2)
            trucks, during = slice(0, len(sizes)), slice(single.stretch.start, single.stretch.stop)
            told.pushes[single.number][during, trucks, trucks] += sizes
    return told


def no_obstacles(regression: Regression) -> Obstacles:
    """Return that nothing was met."""
    return Obstacles([], [np.zeros_like(windows.rounding) for windows in regression.windows])


def _shapes(windows: Windows) -> Array:
    """Return by what a wheel that loses a metre moves each truck, `(3 T,)`: forward, aside, and round."""
    return np.concatenate([(0.5, 0.5, 1.0 / base) for base in windows.signals.block.wheelbase])


def _encounters(regression: Regression) -> list[_Encounter]:
    """Return where something happened, as it shows beside noise, and whiten the regression by that noise."""
    before, noise = -1, regression.noise
    loose: list[Windows] = list(regression.windows)
    for _ in range(TURNS):
        loose, count = freed(regression, _left(regression, loose, noise))
        groups = [_groups(*pair) for pair in zip(regression.windows, loose, strict=True)]
        if sum(map(len, groups)) < ENCOUNTERS:
            return []
        if count == before:
            break
        before, noise = count, estimate_noise(loose, regression.raw, noise, (noise.wave,))
    rows = _left(regression, loose, noise)
    found = []
    for number, (windows, stretches) in enumerate(zip(regression.windows, groups, strict=True)):
        ends = [*(stretch.start for stretch in stretches[1:]), len(windows.ends) - 1]
        ways = travelled(windows)
        found += [
            _seen(
                regression,
                number,
                stretch,
                ways[stretch.start : stretch.stop],
                min(stretch.stop + AFTER, end),
                rows,
            )
            for stretch, end in zip(stretches, ends[: len(stretches)], strict=True)
            if len(stretch) <= LONGEST and not _stands(ways[stretch.start : stretch.stop])
        ]
    return found


def _left(regression: Regression, loose: Sequence[Windows], noise: NoiseLevels) -> Array:
    """Return the data's rows, whitened, without all columns, which are fitted where nothing happened."""
    regression.whiten(noise, loose)
    sizes = regression.sizes()
    regression.whiten(noise)
    return regression.without(sizes)


def _groups(windows: Windows, loose: Windows) -> list[range]:
    """Return the stretches of windows in which trucks are free, and a window before and after each."""
    more = np.einsum("mii->mi", loose.rounding - windows.rounding).sum(axis=1)
    hot = np.flatnonzero(more > 0.0)
    parts = np.split(hot, np.flatnonzero(np.diff(hot) > GAP) + 1) if len(hot) else []
    return [range(max(0, int(part[0]) - 1), min(int(part[-1]) + 2, len(more))) for part in parts]


def _stands(ways: Array) -> bool:
    """Say whether a wheel stands or reverses on its ways (n, W): plays and castors show there."""
    return bool(np.any(np.abs(ways) < STILL * WINDOW) or np.any(np.sign(ways) != np.sign(ways[0])))


def _seen(
    regression: Regression, number: int, stretch: range, ways: Array, end: int, rows: Array
) -> _Encounter:
    """Return an encounter with the products of pushes in each of its windows.

    Args:
        regression: About the recordings.
        number: Of the recording.
        stretch: Of its windows.
        ways: Of wheels in these, `(n, W)` [m].
        end: Window up to which it may show.
        rows: What is left of the data, `(V,)`.
    """
    windows, run = regression.windows[number], regression.filters[number]
    trucks = 3 * len(windows.signals.trucks)
    first, count = stretch.start, len(stretch)
    push = np.zeros((end - first, trucks, count * trucks))
    for at in range(count):
        push[at, range(trucks), at * trucks + np.arange(trucks)] = -1.0
    some, ends = slice(first, end), slice(first, end + 1)
    white = whiten(
        np.ascontiguousarray(run.transition[some]),
        windows.links,
        push,
        np.ascontiguousarray(windows.observe[ends]),
        np.zeros((end - first + 1, windows.measured.shape[1], push.shape[2])),
        np.ascontiguousarray(run.gains[ends]),
        np.ascontiguousarray(run.spread[ends]),
    )
    mine = (regression.owner == number) & (regression.moment > first) & (regression.moment <= end)
    columns = white[len(white) - np.count_nonzero(mine) :]  # without what was measured before
    return _Encounter(number, windows, stretch, ways, columns.T @ columns, columns.T @ rows[mine])


def _crossings(found: Sequence[_Encounter], shaken: float) -> list[list[_Crossing]]:
    """Return what each encounter is if each wheel met an obstacle there, `(E, W)`."""
    answers = []
    for single in found:
        begins = single.windows.time[single.stretch.start : single.stretch.stop]
        trucks = range(len(single.windows.signals.trucks))
        answers.append([its for truck in trucks for its in _crossed(single, truck, shaken, begins)])
    return answers


def _refined(single: _Encounter, wheel: int, shaken: float, its: _Crossing) -> _Crossing:
    """Return a crossing with its begin where it is likeliest between two windows."""
    begins = its.begin + WINDOW * np.linspace(-1.0, 1.0, 2 * PARTS + 1)
    return _crossed(single, wheel // 2, shaken, begins)[wheel % 2]


def _crossed(single: _Encounter, truck: int, shaken: float, begins: Array) -> list[_Crossing]:
    """Return what an encounter is if the left or the right wheel of a truck met an obstacle there.

    The obstacle takes way, inexactly, and shakes all trucks to and fro. Of all begins [s] the likeliest is
    taken; it shares the odds with the others.
    """
    shapes, count = _shapes(single.windows), len(single.stretch)
    own = slice(3 * truck, 3 * truck + 3)
    to_and_fro = np.kron(np.eye(count) - 1.0 / count, np.diag(shaken * shapes))
    rest = np.zeros((count, len(shapes), 3))
    rest[:, own] = OBSTACLE.prior.discrepancy * np.diag(shapes[own]) / count
    pushes = np.column_stack([to_and_fro, rest.reshape(-1, 3)])
    conditional = [
        (size * LOST, math.log(share) + single.evidence(roots), *single.given(roots))
        for size, share in FAULT_SIZE_MIXTURE
        for roots in (size * LOST * pushes,)
    ]
    answers = []
    for wheel in (2 * truck, 2 * truck + 1):
        offers = [_Crossing()]
        for begin in begins.tolist():
            way = _loses(single, wheel, begin)
            if way is None:
                continue
            along, likely = way.ravel(), []
            for size, odds, gram, score in conditional:
                seen, pulled = float(along @ gram @ along), float(along @ score)
                sigma = size / math.sqrt(1.0 + size**2 * seen)
                mean = sigma**2 * pulled
                gain = float(log_evidence(np.array([[seen]]), np.array([pulled]), size))
                gain += math.log(2.0) + float(log_ndtr(mean / sigma))  # of both signs only this
                likely.append((odds + gain, mean))
            total = float(np.logaddexp.reduce([its for its, _ in likely])) - math.log(len(begins))
            offers.append(_Crossing(total, begin, max(likely)[1]))
        answers.append(max(offers, key=lambda its: its.evidence))
    return answers


def _loses(single: _Encounter, wheel: int, begin: float) -> Array | None:
    """Return what each window of an encounter moves trucks (n, 3 T) if a wheel loses a metre from a time on.

    None where the wheel does not roll as far as an obstacle of usual size is long.
    """
    windows, stretch = single.windows, single.stretch
    block = windows.signals.block
    crossing = losing(wheel_radius(block, wheel), LOST).rolled
    edges = windows.time[stretch.start : stretch.stop + 1]
    first, last = np.searchsorted(block.time, (edges[0], edges[-1]))
    gone = np.cumsum(np.abs(block.travel[first:last, wheel]))
    gone = np.interp([begin, *edges], block.time[first:last], gone)
    part = np.diff(np.clip(gone[1:] - gone[0], 0.0, crossing)) / crossing
    if part.sum() < 1.0 - 1e-9:
        return None
    way = np.sign(single.ways[:, wheel])
    trucks = 3 * len(windows.signals.trucks)
    return np.asarray(-(way * part)[:, None] * windows.lever[stretch.start : stretch.stop, wheel, :trucks])


def _otherwise(single: _Encounter) -> float:
    """Return the log evidence of anything else than an obstacle.

    A truck was pushed, or only turned, or only moved to and fro: a joint that reads wrongly, by a play, say,
    is a truck that turns, and a link that does a truck that moves ahead. Or a wheel slipped all the time.
    """
    windows, stretch = single.windows, single.stretch
    trucks, count = len(windows.signals.trucks), len(stretch)
    levers = windows.lever[stretch.start : stretch.stop, :, : 3 * trucks]
    roots = []
    for truck in range(trucks):
        whole = np.zeros((count, 3 * trucks, 3))
        whole[:, 3 * truck : 3 * truck + 3] = np.diag(SHOVE)
        ahead = SHOVE[0] * (levers[:, 2 * truck] + levers[:, 2 * truck + 1])
        shapes = (whole, whole[:, :, 2:], ahead[:, :, None])
        roots += [
            np.einsum("ij,jkl->ikjl", np.eye(count), shape).reshape(3 * trucks * count, -1)
            for shape in shapes
        ]
    if count * WINDOW >= SHORTEST:
        lost = single.ways[:, :, None] * levers
        roots += [SLIP * lost[:, wheel].reshape(-1, 1) for wheel in range(2 * trucks)]
    parts = [
        math.log(share) + single.evidence(size * root) for root in roots for size, share in FAULT_SIZE_MIXTURE
    ]
    return float(np.logaddexp.reduce(parts)) - math.log(len(roots))


def _mixtures(table: Array, other: Array) -> tuple[float, list[float], Array]:
    """Return how likely encounters are, the log odds of each wheel (W,), and each one's shares (E, W).

    Args:
        table: Log evidence of each encounter for an obstacle under each wheel, `(E, W)`.
        other: The same for anything else, `(E,)`.
    """
    count, wheels = table.shape
    fewer = OBSTACLE.prior.log_odds - 0.5 * math.log(count)  # and what another weight of a mixture costs
    worths, mixtures = {}, {}
    for met in itertools.product((False, True), repeat=wheels):
        likely, mixtures[met] = _mixed(np.column_stack([table[:, met], other]))
        worths[met] = likely + sum(met) * fewer
    odds = []
    for at in range(wheels):
        there, without = (
            np.logaddexp.reduce([worth for met, worth in worths.items() if met[at] == is_met])
            for is_met in (True, False)
        )
        odds.append(float(there - without))
    best = max(worths, key=lambda met: worths[met])
    shares = np.zeros(table.shape)
    shares[:, best] = mixtures[best][:, :-1]
    return float(np.logaddexp.reduce(list(worths.values()))), odds, shares


def _mixed(table: Array) -> tuple[float, Array]:
    """Return the largest log likelihood of a mixture, and each case's shares, of log evidences (E, K)."""
    weights = np.full(table.shape[1], 1.0 / table.shape[1])
    for _ in range(50):
        parts = table + np.log(np.maximum(weights, 1e-300))
        total = np.logaddexp.reduce(parts, axis=1)
        shares = np.exp(parts - total[:, None])
        weights = shares.mean(axis=0)
    return float(total.sum()), shares
