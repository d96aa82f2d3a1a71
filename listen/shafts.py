"""Groups of signals that measure the same shaft: positions, copies and speeds, on a common clock.

A speed is matched to the position whose rate explains it best by linear regression, by the ratio of the
likelihoods of normally distributed residuals.
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

CLOCK_STEP = 0.04  # [s] of the common clock: robots of some hundred kg change speed in 0.1 s or more
CORRELATION_TIME = 1.0  # [s] correlation time of a movement (assumption)
MAX_INTERVAL = 4.0 * CLOCK_STEP  # [s] largest median interval of a signal that is used
# Share of a speed's variance that the rate of its position explains; 5 % are left for noise, filters and
# delays. Assumption.
MIN_EXPLAINED_SHARE = 0.95
MIN_DISTINCT_VALUES = 6  # distinct values of a signal that is used (assumption)
MIN_SAMPLES = 16  # values of a signal, and steps of the common clock (assumption)
LAGS = (-2, -1, 0, 1, 2, 3)  # [steps] trial delays of a filtered speed


@dataclass(frozen=True)
class Track:
    """A signal resampled to the common clock."""

    signal: LearnedSignal
    start: float  # time at which the clock begins [s]
    value: NDArray[np.float64]  # its unwrapped value [counts], shape `(M,)`
    rate: NDArray[np.float64]  # its rate by central differences [counts/s], shape `(M,)`
    noise: float  # limit of the rate's error by the resolution of one count [counts/s]


@dataclass(frozen=True)
class Shaft:
    """Signals that measure one movement.

    Attributes:
        position: The main position signal.
        copies: Other positions of the same movement, each as (signal, its counts per count of `position`).
        rates: Signals proportional to its speed, each as (signal, its counts per count/s of the position,
            share of its variance that the position's rate explains [0 to 1]).
    """

    position: Track
    copies: tuple[tuple[LearnedSignal, float], ...] = ()
    rates: tuple[tuple[LearnedSignal, float, float], ...] = ()


def tracks_of(signals: Sequence[LearnedSignal]) -> list[Track]:
    """Return the signals that may measure a movement, resampled to a common clock; others are left out."""
    usable = [signal for signal in signals if _is_trackable(signal)]
    if not usable:
        return []
    start = max(float(signal.time[0]) for signal in usable)
    end = min(float(signal.time[-1]) for signal in usable)
    clock = np.arange(start, end, CLOCK_STEP)
    return [_track(signal, clock) for signal in usable] if len(clock) > MIN_SAMPLES else []


def _is_trackable(signal: LearnedSignal) -> bool:
    if signal.kind not in {"number", "float"} or len(signal.time) < MIN_SAMPLES:
        return False
    if np.median(np.diff(signal.time)) > MAX_INTERVAL:
        return False
    return len(np.unique(signal.raw[:20000])) >= MIN_DISTINCT_VALUES


def _track(signal: LearnedSignal, clock: NDArray[np.float64]) -> Track:
    time, value = signal.time, signal.unwrapped()
    median_interval = float(np.median(np.diff(time)))
    # A device that sends only changes pauses while its value is constant: repeat the last one before the
    # next.
    gaps = np.flatnonzero(np.diff(time) > 3 * median_interval)
    time = np.insert(time, gaps + 1, time[gaps + 1] - median_interval)
    value = np.insert(value, gaps + 1, value[gaps])
    resampled = np.interp(clock, time, value)
    rate = np.convolve(resampled, np.array([1.0, 0.0, -1.0]) / (2 * CLOCK_STEP), "same")
    rate[[0, -1]] = rate[[1, -2]]
    return Track(signal, float(clock[0]), resampled, rate, 0.5 / CLOCK_STEP)


def find_shafts(tracks: Sequence[Track], drives: Collection[int]) -> list[Shaft]:
    """Return the measured movements on one clock: each position with its copies and rates.

    Two positions in one message of a drive may be its demanded and its actual position. In a message of any
    other device they belong to two sensors, even if they move alike.
    """
    is_rate: dict[int, tuple[int, float, float]] = {}
    for number, track in enumerate(tracks):
        match = _position_of(number, track, tracks)
        if match is not None:
            is_rate[number] = match
    positions = [number for number in range(len(tracks)) if number not in is_rate]
    groups: list[list[tuple[int, float]]] = []
    for number in positions:
        for group in groups:
            one, other = tracks[group[0][0]], tracks[number]
            may_be_same = one.signal.can_id != other.signal.can_id or one.signal.node in drives
            ratio = _position_ratio(one, other) if may_be_same else 0.0
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
        copies = tuple((tracks[number].signal, ratio) for number, ratio in group[1:])
        shafts.append(Shaft(tracks[group[0][0]], copies, rates))
    return shafts


def effective_samples(count: int) -> float:
    """Return the number of independent samples in `count` steps of the clock, at least 4."""
    return max(count * CLOCK_STEP / CORRELATION_TIME, 4.0)


def _position_of(number: int, track: Track, tracks: Sequence[Track]) -> tuple[int, float, float] | None:
    """Return the position whose rate a track is, its counts per count/s, and the explained share; or None."""
    scores: list[tuple[float, float, int]] = []
    for other, position in enumerate(tracks):
        if other == number or np.std(position.rate) <= 2 * position.noise:
            continue
        share, factor = max(_explained_share(track.value, position.rate, lag) for lag in LAGS)
        scores.append((share, factor, other))
    scores.sort(reverse=True)
    if not scores or scores[0][0] < MIN_EXPLAINED_SHARE:
        return None
    share, factor, other = scores[0]
    # A position of the same node is preferred, even if that of another node explains more.
    same_node = [score for score in scores if tracks[score[2]].signal.node == track.signal.node]
    if track.signal.node and same_node and same_node[0][0] >= MIN_EXPLAINED_SHARE:
        share, factor, other = same_node[0]
    return other, factor, share


def _explained_share(value: NDArray[np.float64], rate: NDArray[np.float64], lag: int) -> tuple[float, float]:
    """Return the share of the variance of `value` that `rate` explains by linear regression, and the factor.

    `lag` is the delay of the value after the rate [steps of the clock].
    """
    late = value[max(lag, 0) : len(value) + min(lag, 0)]
    early = rate[max(-lag, 0) : len(rate) - max(lag, 0)]
    power = float(early @ early)
    total = float(np.var(late)) * len(late)  # about the mean, so that a constant speed explains no constant
    if not power or not total:
        return 0.0, 0.0
    factor = float(early @ late) / power
    residual = late - factor * early
    return 1.0 - float(residual @ residual) / total, factor


def _position_ratio(one: Track, other: Track) -> float:
    """Return the counts of `other` per count of `one` if they are copies of one position; otherwise 0.

    Two signals of one node are copies if they differ by resolution, noise and delay only.
    """
    if one.signal.node != other.signal.node or not one.signal.node:
        return 0.0
    share, factor = max(_explained_share(other.rate, one.rate, lag) for lag in (-1, 0, 1))
    if share < MIN_EXPLAINED_SHARE or not factor:
        return 0.0
    # The rate in the regression models the delay between the two samplings.
    table = np.array([one.value - one.value[0], one.rate, np.ones(len(one.value))]).T
    fit = np.linalg.lstsq(table, other.value, rcond=None)[0]
    residual = other.value - table @ fit
    allowed = 3.0 * max(1.0, abs(factor)) + 0.001 * float(np.ptp(other.value))
    return float(fit[0]) if math.sqrt(float(np.mean(residual * residual))) < allowed else 0.0
