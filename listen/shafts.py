"""Signals of one shaft: positions, their speeds, and what follows them; on a common clock.

A speed is the rate of a position: the two are held against each other by linear regression, and the position
that leaves the least is the one, by the ratio of likelihoods of what is left (both normally distributed).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from omnimate.listen.signals import LearnedSignal

STEP = 0.04  # [s] of the common clock: robots of some hundred kg change their speed in 0.1 s and more
MEMORY = 1.0  # [s] for which a movement resembles itself; samples further apart are taken for independent
SLOWEST = 4.0 * STEP  # [s] longest median interval of a signal that can be followed on it
EXPLAINED = 0.95  # share of a speed's variance that a position explains: 5 % for noise, filters and delays
FEWEST_VALUES = 6  # different ones, or else nothing can be said about how a number moves
LAGS = (-2, -1, 0, 1, 2, 3)  # steps by which a filtered speed may be late, or early with the sampling


@dataclass(frozen=True)
class Track:
    """A number on the common clock.

    Attributes:
        signal: The signal.
        start: Time at which the clock begins [s].
        value: Its value, unwrapped, shape `(M,)`.
        rate: Its rate per second, over three steps, shape `(M,)`.
        noise: Standard deviation of the rate that one count of resolution makes.
    """

    signal: LearnedSignal
    start: float
    value: NDArray[np.float64]
    rate: NDArray[np.float64]
    noise: float


@dataclass(frozen=True)
class Shaft:
    """Signals that measure one movement.

    Attributes:
        position: The signal that shows it best.
        same: Others that show the same position, with their ratio to it.
        rates: Signals proportional to its speed, with counts for each count per second and the share of
            their variance that it explains.
    """

    position: Track
    same: tuple[tuple[LearnedSignal, float], ...] = ()
    rates: tuple[tuple[LearnedSignal, float, float], ...] = ()


def tracks_of(signals: Sequence[LearnedSignal]) -> list[Track]:
    """Return the numbers that can be followed, on a common clock."""
    usable = [signal for signal in signals if _can_be_followed(signal)]
    if not usable:
        return []
    start = max(float(signal.time[0]) for signal in usable)
    end = min(float(signal.time[-1]) for signal in usable)
    clock = np.arange(start, end, STEP)
    return [_track(signal, clock) for signal in usable] if len(clock) > 16 else []


def _can_be_followed(signal: LearnedSignal) -> bool:
    if signal.kind not in {"number", "float"} or len(signal.time) < 16:
        return False
    if np.median(np.diff(signal.time)) > SLOWEST:
        return False
    return len(np.unique(signal.raw[:20000])) >= FEWEST_VALUES


def _track(signal: LearnedSignal, clock: NDArray[np.float64]) -> Track:
    time, value = signal.time, signal.unwrapped()
    usual = float(np.median(np.diff(time)))
    # A device that sends changes is silent while nothing changes: its last value holds.
    gaps = np.flatnonzero(np.diff(time) > 3 * usual)
    time = np.insert(time, gaps + 1, time[gaps + 1] - usual)
    value = np.insert(value, gaps + 1, value[gaps])
    at = np.interp(clock, time, value)
    rate = np.convolve(at, np.array([1.0, 0.0, -1.0]) / (2 * STEP), "same")
    rate[[0, -1]] = rate[[1, -2]]
    return Track(signal, float(clock[0]), at, rate, 0.5 / STEP)


def find_shafts(tracks: Sequence[Track], drives: Collection[int]) -> list[Shaft]:
    """Return the movements that are measured: each position with its copies and its rates.

    Two positions in one message of a drive may be its demand and its actual value; those of any other device
    are of two sensors, even if they move alike.
    """
    is_rate: dict[int, tuple[int, float, float]] = {}
    for number, track in enumerate(tracks):
        found = _position_of(number, track, tracks)
        if found is not None:
            is_rate[number] = found
    positions = [number for number in range(len(tracks)) if number not in is_rate]
    groups: list[list[tuple[int, float]]] = []
    for number in positions:
        for group in groups:
            one, other = tracks[group[0][0]], tracks[number]
            may_be_same = one.signal.can_id != other.signal.can_id or one.signal.node in drives
            ratio = _same(one, other) if may_be_same else 0.0
            if ratio:
                group.append((number, ratio))
                break
        else:
            groups.append([(number, 1.0)])
    shafts = []
    for group in groups:
        members = {number for number, _ in group}
        rates = tuple(
            (tracks[number].signal, factor, share)
            for number, (position, factor, share) in is_rate.items()
            if position in members
        )
        best = tracks[group[0][0]]
        same = tuple((tracks[number].signal, ratio) for number, ratio in group[1:])
        shafts.append(Shaft(best, same, rates))
    return shafts


def independent(count: int) -> float:
    """Return how many independent samples so many steps of the clock are worth."""
    return max(count * STEP / MEMORY, 4.0)


def _position_of(number: int, track: Track, tracks: Sequence[Track]) -> tuple[int, float, float] | None:
    """Return the position whose rate a number is, counts per count and second, and the explained share."""
    scores: list[tuple[float, float, int]] = []
    for other, position in enumerate(tracks):
        if other == number or np.std(position.rate) <= 2 * position.noise:
            continue
        share, factor = max(_explained(track.value, position.rate, lag) for lag in LAGS)
        scores.append((share, factor, other))
    scores.sort(reverse=True)
    if not scores or scores[0][0] < EXPLAINED:
        return None
    share, factor, other = scores[0]
    # Of two numbers each the rate of the other none is; a position's own rate explains it badly.
    same_node = [each for each in scores if tracks[each[2]].signal.node == track.signal.node]
    if track.signal.node and same_node and same_node[0][0] >= EXPLAINED:
        share, factor, other = same_node[0]
    return other, factor, share


def _explained(value: NDArray[np.float64], rate: NDArray[np.float64], lag: int) -> tuple[float, float]:
    """Return the share of a number's variance that a rate explains with a lag, and the factor."""
    late = value[max(lag, 0) : len(value) + min(lag, 0)]
    early = rate[max(-lag, 0) : len(rate) - max(lag, 0)]
    power = float(early @ early)
    whole = float(np.var(late)) * len(late)  # about the mean: a steady drive explains no constant
    if not power or not whole:
        return 0.0, 0.0
    factor = float(early @ late) / power
    left = late - factor * early
    return 1.0 - float(left @ left) / whole, factor


def _same(one: Track, other: Track) -> float:
    """Return how many counts of the other a count is, where both show the same movement; else 0.

    Two signals of one node do where nothing but their resolution and noise is between them.
    """
    if one.signal.node != other.signal.node or not one.signal.node:
        return 0.0
    share, factor = max(_explained(other.rate, one.rate, lag) for lag in (-1, 0, 1))
    if share < EXPLAINED or not factor:
        return 0.0
    # What is left is resolution, and the delay between the two samplings.
    table = np.array([one.value - one.value[0], one.rate, np.ones(len(one.value))]).T
    fit = np.linalg.lstsq(table, other.value, rcond=None)[0]
    left = other.value - table @ fit
    allowed = 3.0 * max(1.0, abs(factor)) + 0.001 * float(np.ptp(other.value))
    return float(fit[0]) if math.sqrt(float(np.mean(left * left))) < allowed else 0.0
