"""Obstacles that are crossed many times, identified before all other effects.

A wheel that climbs over an obstacle loses travel; it also shakes the robot, sways it on its tyres and pulls
at the linkage, in a way that no model describes. On a smooth floor that exceeds the noise many times, and a
search that adds event after event would explain it by whatever fits. The lasting displacement is clear all
the same. So disturbed windows are grouped into encounters, and each is explained as a whole: a wheel lost
travel while the trucks were disturbed, or anything else. Which wheels cross obstacles follows from a
mixture model over all encounters.
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
from omnimate.effects.crossing import crossing_with_loss
from omnimate.effects.effect import WHEEL
from omnimate.mismatch.candidates.pushes import PUSH_SIZE
from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.evidence.density import FAULT_SIZE_MIXTURE, log_evidence
from omnimate.mismatch.noise.levels import estimate_noise
from omnimate.mismatch.noise.whitening import whiten
from omnimate.mismatch.recording.signals import WINDOW
from omnimate.mismatch.scans.disturbances import inflate_disturbed_windows
from omnimate.mismatch.scans.events import travelled
from omnimate.mismatch.scans.nonlinear import SHORTEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

MIN_ENCOUNTERS = 6  # fewer obstacles are left to the search
MAX_GAP = 2  # [windows] within an encounter: a slow wheel takes half a second to pass an obstacle
AFTER = 8  # [windows] after an encounter whose measurements still depend on it
MAX_LENGTH = 24  # [windows] of an encounter: a longer disturbance is no crossing
MAX_ITERATIONS = 4  # of disturbed windows, and of the noise without them
SHAKING = (0.15, 0.3, 0.6, 1.2)  # [1] shaking during an encounter, over the lasting displacement
PARTS = 8  # of a window, to which the beginning of a crossing is refined
MAX_LOG_ODDS = 200.0  # larger ones differ by rounding errors alone
MIN_SPEED = 0.01  # [m/s] a slower wheel stops or reverses


@dataclass(frozen=True, slots=True)
class Train(Term):
    """All obstacles under one wheel as a candidate of one column, with the ratios of their sizes fixed."""

    shares: tuple[float, ...] = ()  # travel lost at each, over the mean of all, `(K,)`
    mean: float = 1.0  # mean travel lost, in declared sizes

    def built(self, coefficients: Array) -> Effect:
        """Return the obstacles with this coefficient `(1,)`."""
        return _obstacles(self.component, self.fixed["times"], max(float(coefficients[0]), 0.0), self.shares)

    @property
    def ordinary_size(self) -> float:
        """What any robot meets at each obstacle differs, and their mean is less."""
        return OBSTACLE.prior.background / math.sqrt(len(self.shares))

    @property
    def held(self) -> float:
        """Fixed size: fitting it would absorb the transient shaking."""
        return self.mean

    def at(self, **fixed: Any) -> Term:  # noqa: ANN401
        """Return the obstacles at other moments."""
        return train(self.component, tuple(fixed["times"]), self.shares, self.mean, self.odds)


OBSTACLE = effects_scanned_by("moments", WHEEL[0])[0]
SLIP = effects_scanned_by("interval", WHEEL[0])[0].estimated().scale  # [1] declared size
LOST = OBSTACLE.estimated().scale  # [m] declared size


def _obstacles(wheel: str, times: tuple[float, ...], size: float, shares: Sequence[float]) -> Effect:
    """Return obstacles under a wheel at times [s], of a mean size in declared ones and shares of it."""
    lost = tuple((size * LOST * np.array(shares)).tolist())
    values: dict[str, Any] = {"times": times, OBSTACLE.linear: lost}
    return OBSTACLE(component=wheel, **values)


def train(wheel: str, times: tuple[float, ...], shares: tuple[float, ...], mean: float, odds: float) -> Train:
    """Return the candidate of all obstacles under one wheel.

    Crossings begin at `times` [s], in order, and lose shares of a mean travel, which is in declared sizes;
    `odds` are log odds a priori.
    """
    probe = _obstacles(wheel, times, 1.0, shares)
    return Train(
        OBSTACLE.name, wheel, (probe,), {"times": times}, odds, positive=True, shares=shares, mean=mean
    )


@dataclass(frozen=True, slots=True)
class Obstacles:
    """Obstacles that wheels crossed many times."""

    terms: list[Train]  # obstacles under each wheel that crossed any
    disturbances: list[Array]  # recordings' process covariances of shaking in encounters, `(M, n, n)`
    noise: NoiseLevels  # noise levels without disturbed windows

    @property
    def values(self) -> list[Array]:
        """Coefficients of the terms."""
        return [np.array([term.held]) for term in self.terms]


@dataclass(frozen=True, slots=True)
class _Encounter:
    """A stretch of disturbed windows."""

    number: int  # number of the recording
    windows: Windows  # linear model of the recording
    stretch: slice  # numbers of the disturbed windows
    travel: Array  # travel of each wheel in each of them, `(n, W)` [m]
    gram: Array  # products of the columns of pushes in each of them with each other, `(n 3 T, n 3 T)`
    score: Array  # products of these columns with the residual of the data, `(n 3 T,)`

    def evidence(self, pushes: Array) -> float:
        """Return the log evidence of pushes, of a covariance with the root `pushes` (n 3 T, k)."""
        return float(log_evidence(pushes.T @ self.gram @ pushes, pushes.T @ self.score, 1.0))

    def given(self, pushes: Array) -> tuple[Array, Array]:
        """Return gram and score with such pushes as noise."""
        shared = self.gram @ pushes
        precision = pushes.T @ shared + np.eye(pushes.shape[1])
        fitted = np.linalg.solve(precision, np.column_stack([shared.T, pushes.T @ self.score]))
        return self.gram - shared @ fitted[:, :-1], self.score - shared @ fitted[:, -1]


@dataclass(frozen=True, slots=True)
class _Crossing:
    """An encounter explained as the crossing of an obstacle by a wheel."""

    evidence: float = -math.inf  # log Bayes factor against no disturbance
    begin: float = 0.0  # time at which it begins [s]
    lost: float = 0.0  # travel lost [m]


def find_obstacles(regression: Regression) -> Obstacles:
    """Return the obstacles that wheels crossed many times, and the noise levels without them.

    The regression is about the nominal robot, with the columns of startup nuisances, whitened by the noise
    levels of such a robot.
    """
    encounters, noise = _encounters(regression)
    if len(encounters) < MIN_ENCOUNTERS:
        return no_obstacles(regression)
    wheels = regression.windows[0].signals.wheels
    crossings = [_crossings(encounters, shaking) for shaking in SHAKING]
    other = np.array([_other_evidence(encounter) for encounter in encounters])
    tables = [np.array([[crossing.evidence for crossing in row] for row in table]) for table in crossings]
    mixtures = [_mixtures(table, other) for table in tables]
    best = max(range(len(SHAKING)), key=lambda number: mixtures[number][0])
    _, odds, shares = mixtures[best]
    terms, disturbances = [], no_obstacles(regression).disturbances
    for number, wheel in enumerate(wheels):
        pairs = [
            (encounter, _refined(encounter, number, SHAKING[best], row[number]))
            for encounter, row, share in zip(encounters, crossings[best], shares[:, number], strict=True)
            if share > 0.5
        ]
        pairs = [(encounter, crossing) for encounter, crossing in pairs if crossing.lost > 0.0]
        if odds[number] <= 0.0 or len(pairs) < MIN_ENCOUNTERS:
            continue
        mean = float(np.mean([crossing.lost for _, crossing in pairs]))
        times = tuple(crossing.begin for _, crossing in pairs)
        parts = tuple(crossing.lost / mean for _, crossing in pairs)
        terms.append(train(wheel, times, parts, mean / LOST, min(MAX_LOG_ODDS, odds[number])))
        for encounter, crossing in pairs:
            covariance = np.diag((SHAKING[best] * crossing.lost * _shapes(encounter.windows)) ** 2)
            poses = slice(len(covariance))
            disturbances[encounter.number][encounter.stretch, poses, poses] += covariance
    return Obstacles(terms, disturbances, noise if terms else regression.noise)


def no_obstacles(regression: Regression) -> Obstacles:
    """Return no obstacles, and the noise of a regression."""
    disturbances = [np.zeros_like(windows.rounding) for windows in regression.windows]
    return Obstacles([], disturbances, regression.noise)


def _shapes(windows: Windows) -> Array:
    """Return the size of each truck's motion (forward, left, yaw) by a metre of lost travel, `(3 T,)`."""
    return np.concatenate([(0.5, 0.5, 1.0 / base) for base in windows.signals.block.wheelbase])


def _encounters(regression: Regression) -> tuple[list[_Encounter], NoiseLevels]:
    """Return the stretches of disturbed windows, and the noise levels without these windows."""
    before, noise = -1, regression.noise
    inflated: list[Windows] = list(regression.windows)
    for _ in range(MAX_ITERATIONS):
        inflated, count = inflate_disturbed_windows(*_residual(regression, inflated, noise))
        groups = [_groups(*pair) for pair in zip(regression.windows, inflated, strict=True)]
        if sum(map(len, groups)) < MIN_ENCOUNTERS:
            return [], noise
        if count == before:
            break
        before, noise = count, estimate_noise(inflated, regression.raw, noise, (noise.wave,))
    regression, rows = _residual(regression, inflated, noise)
    encounters = []
    for number, (windows, stretches) in enumerate(zip(regression.windows, groups, strict=True)):
        ends = [*(stretch.start for stretch in stretches[1:]), len(windows.ends) - 1]
        travel = travelled(windows)
        encounters += [
            _encounter(regression, number, stretch, travel[stretch], min(stretch.stop + AFTER, end), rows)
            for stretch, end in zip(stretches, ends[: len(stretches)], strict=True)
            if stretch.stop - stretch.start <= MAX_LENGTH and not _stops(travel[stretch])
        ]
    return encounters, noise


def _residual(
    regression: Regression, inflated: Sequence[Windows], noise: NoiseLevels
) -> tuple[Regression, Array]:
    """Return the regression with other noise, and its residual by a fit to undisturbed windows."""
    coefficients = regression.with_noise(noise, inflated).coefficients()
    whitened = regression.with_noise(noise)
    return whitened, whitened.residual(coefficients)


def _groups(windows: Windows, inflated: Windows) -> list[slice]:
    """Return stretches of disturbed windows, each with the window before and the one after."""
    added_variance = np.einsum("mii->mi", inflated.rounding - windows.rounding).sum(axis=1)
    disturbed = np.flatnonzero(added_variance > 0.0)
    groups = np.split(disturbed, np.flatnonzero(np.diff(disturbed) > MAX_GAP) + 1) if len(disturbed) else []
    return [
        slice(max(0, int(group[0]) - 1), min(int(group[-1]) + 2, len(added_variance))) for group in groups
    ]


def _stops(travel: Array) -> bool:
    """Say whether a wheel stands or reverses, by its travel (n, W): backlash and castors show there."""
    return bool(np.any(np.abs(travel) < MIN_SPEED * WINDOW) or np.any(np.sign(travel) != np.sign(travel[0])))


def _encounter(
    regression: Regression, number: int, stretch: slice, travel: Array, end: int, rows: Array
) -> _Encounter:
    """Return an encounter with the products of pushes in each of its windows.

    In the disturbed windows of `stretch` the wheels travel (n, W) [m]; measurements until the window `end`
    may depend on them. `rows` (V,) is the whitened residual of the data.
    """
    windows, run = regression.windows[number], regression.filters[number]
    trucks = 3 * len(windows.signals.trucks)
    first, count = stretch.start, len(travel)
    push = np.zeros((end - first, trucks, count * trucks))
    for at in range(count):
        push[at, range(trucks), at * trucks + np.arange(trucks)] = -1.0
    steps, ends = slice(first, end), slice(first, end + 1)
    white = whiten(
        np.ascontiguousarray(run.transition[steps]),
        windows.links,
        push,
        np.ascontiguousarray(windows.observe[ends]),
        np.zeros((end - first + 1, windows.measured.shape[1], push.shape[2])),
        np.ascontiguousarray(run.gains[ends]),
        np.ascontiguousarray(run.spread[ends]),
    )
    in_encounter = (regression.owner == number) & (regression.moment > first) & (regression.moment <= end)
    columns = white[len(white) - np.count_nonzero(in_encounter) :]  # not those before its first window ends
    return _Encounter(number, windows, stretch, travel, columns.T @ columns, columns.T @ rows[in_encounter])


def _crossings(encounters: Sequence[_Encounter], shaking: float) -> list[list[_Crossing]]:
    """Return each encounter explained as the crossing of an obstacle by each wheel, `(E, W)`."""
    return [
        [
            crossing
            for truck in range(len(encounter.windows.signals.trucks))
            for crossing in _crossed(encounter, truck, shaking, encounter.windows.time[encounter.stretch])
        ]
        for encounter in encounters
    ]


def _refined(encounter: _Encounter, wheel: int, shaking: float, crossing: _Crossing) -> _Crossing:
    """Return a crossing with its beginning at the most probable time between two windows."""
    begins = crossing.begin + WINDOW * np.linspace(-1.0, 1.0, 2 * PARTS + 1)
    return _crossed(encounter, wheel // 2, shaking, begins)[wheel % 2]


def _crossed(encounter: _Encounter, truck: int, shaking: float, begins: Array) -> list[_Crossing]:
    """Return an encounter explained as a crossing by the left, and by the right wheel of a truck.

    The wheel loses travel, with a discrepancy, and all trucks are disturbed. Of all times [s] at
    which it may begin, the most probable is taken, with the evidence averaged over all.
    """
    shapes, count = _shapes(encounter.windows), len(encounter.travel)
    part = slice(3 * truck, 3 * truck + 3)
    to_and_fro = np.kron(np.eye(count) - 1.0 / count, np.diag(shaking * shapes))
    rest = np.zeros((count, len(shapes), 3))
    rest[:, part] = OBSTACLE.prior.discrepancy * np.diag(shapes[part]) / count
    pushes = np.column_stack([to_and_fro, rest.reshape(-1, 3)])
    conditional = [
        (size * LOST, math.log(share) + encounter.evidence(roots), *encounter.given(roots))
        for size, share in FAULT_SIZE_MIXTURE
        for roots in (size * LOST * pushes,)
    ]
    crossings = []
    for wheel in (2 * truck, 2 * truck + 1):
        candidates = [_Crossing()]
        for begin in begins.tolist():
            displacement = _loses(encounter, wheel, begin)
            if displacement is None:
                continue
            displacements, sizes = displacement.ravel(), []
            for size, odds, gram, score in conditional:
                information, product = displacements @ gram @ displacements, displacements @ score
                sigma = size / math.sqrt(1.0 + size**2 * information)
                mean = float(sigma**2 * product)
                gain = float(log_evidence(np.array([[information]]), np.array([product]), size))
                gain += math.log(2.0) + float(log_ndtr(mean / sigma))  # the sign is known
                sizes.append((odds + gain, mean))
            total = float(np.logaddexp.reduce([evidence for evidence, _ in sizes])) - math.log(len(begins))
            candidates.append(_Crossing(total, begin, max(sizes)[1]))
        crossings.append(max(candidates, key=lambda crossing: crossing.evidence))
    return crossings


def _loses(encounter: _Encounter, wheel: int, begin: float) -> Array | None:
    """Return the motion of the trucks (n, 3 T) in each window if a wheel loses a metre from a time on.

    None where the wheel does not roll over the whole of an obstacle of the declared size.
    """
    windows, stretch = encounter.windows, encounter.stretch
    block = windows.signals.block
    crossing = crossing_with_loss(wheel_radius(block, wheel), LOST).rolled
    edges = windows.time[stretch.start : stretch.stop + 1]
    first, last = np.searchsorted(block.time, (edges[0], edges[-1]))
    rolled = np.cumsum(np.abs(block.travel[first:last, wheel]))
    rolled = np.interp([begin, *edges], block.time[first:last], rolled)
    part = np.diff(np.clip(rolled[1:] - rolled[0], 0.0, crossing)) / crossing
    if part.sum() < 1.0 - 1e-9:
        return None
    direction = np.sign(encounter.travel[:, wheel])
    trucks = 3 * len(windows.signals.trucks)
    return np.asarray(-(direction * part)[:, None] * windows.lever[stretch, wheel, :trucks])


def _other_evidence(encounter: _Encounter) -> float:
    """Return the log evidence of an encounter without an obstacle.

    A truck was pushed, only turned, or only moved forward and back: a joint with backlash resembles a truck
    that turns, a link with backlash one that moves forward. Or a wheel slipped all the time.
    """
    trucks, count = len(encounter.windows.signals.trucks), len(encounter.travel)
    levers = encounter.windows.lever[encounter.stretch, :, : 3 * trucks]
    roots = []
    for truck in range(trucks):
        pushes = np.zeros((count, 3 * trucks, 3))
        pushes[:, 3 * truck : 3 * truck + 3] = np.diag(PUSH_SIZE)
        ahead = PUSH_SIZE[0] * (levers[:, 2 * truck] + levers[:, 2 * truck + 1])
        shapes = (pushes, pushes[:, :, 2:], ahead[:, :, None])
        roots += [
            np.einsum("ij,jkl->ikjl", np.eye(count), shape).reshape(3 * trucks * count, -1)
            for shape in shapes
        ]
    if count * WINDOW >= SHORTEST:
        slip = encounter.travel[:, :, None] * levers
        roots += [SLIP * slip[:, wheel].reshape(-1, 1) for wheel in range(2 * trucks)]
    parts = [
        math.log(share) + encounter.evidence(size * root)
        for root in roots
        for size, share in FAULT_SIZE_MIXTURE
    ]
    return float(np.logaddexp.reduce(parts)) - math.log(len(roots))


def _mixtures(table: Array, other: Array) -> tuple[float, list[float], Array]:
    """Return the log likelihood of encounters, log odds of each wheel (W,), and responsibilities (E, W).

    `table` (E, W) has encounters' log evidence for an obstacle under each wheel, and `other` (E,) for none.
    """
    count, wheels = table.shape
    prior = OBSTACLE.prior.log_odds - 0.5 * math.log(count)  # less the BIC of one more mixture weight
    log_odds, mixtures = {}, {}
    for crossing in itertools.product((False, True), repeat=wheels):
        likelihood, mixtures[crossing] = _mixed(np.column_stack([table[:, crossing], other]))
        log_odds[crossing] = likelihood + sum(crossing) * prior
    odds = []
    for wheel in range(wheels):
        with_obstacles, without = (
            np.logaddexp.reduce(
                [value for crossing, value in log_odds.items() if crossing[wheel] == has_obstacles]
            )
            for has_obstacles in (True, False)
        )
        odds.append(float(with_obstacles - without))
    best = max(log_odds, key=lambda crossing: log_odds[crossing])
    shares = np.zeros(table.shape)
    shares[:, best] = mixtures[best][:, :-1]
    return float(np.logaddexp.reduce(list(log_odds.values()))), odds, shares


def _mixed(table: Array) -> tuple[float, Array]:
    """Return the largest log likelihood of a mixture of log evidences (E, K), and responsibilities (E, K)."""
    weights = np.full(table.shape[1], 1.0 / table.shape[1])
    for _ in range(50):
        parts = table + np.log(np.maximum(weights, 1e-300))
        total = np.logaddexp.reduce(parts, axis=1)
        shares = np.exp(parts - total[:, None])
        weights = shares.mean(axis=0)
    return float(total.sum()), shares
