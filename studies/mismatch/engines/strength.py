r"""How strong an effect stands in a recording: the Cramer-Rao bound, by numerical differences alone.

The residual of a recording is what dead reckoning misses (`residual`). With an effect of size p it changes by
J p. With noise of covariance C, and nuisances N that are estimated too, the bound is

    sigma^-2 = J' W (1 - P) W' J,   W W' = C^-1,   P = the projection on W' N

so that a change D = J p stands `|(1 - P) W' D| = p / sigma` standard deviations above the noise: its
strength. The same norm is used for changes that are not in proportion to p.

The noise is estimated from the residual itself: real odometry errors and pose errors are correlated in time.
W is diagonal in frequency (Whittle, Arkiv for Matematik 2, 1953): each column's Fourier coefficients are
divided by the root of its power spectrum, a running mean of the periodograms of all recordings. Columns are
taken as independent. Where there are a few poses only, at stops, the noise is taken as white.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.vocabulary import TRUCKS, WHEELS, Array

Residual = Mapping[str, Array]

SMOOTHING = 0.2  # [s] over which speeds are taken; a count of 0.1 mm is then 0.5 mm/s


@dataclass(frozen=True, slots=True)
class Poses:
    time: Array  # stamp of each pose [s], shape `(M,)`
    pose: Array  # measured x [m], y [m] and heading [rad], the heading unwrapped, shape `(M, 3)`


@dataclass(frozen=True, slots=True)
class Drive:
    """One recording of a robot with T trucks and W = 2 T wheels."""

    time: Array  # time of each sample [s], shape `(N,)`
    way: Array  # way of each wheel by its counter, from the counter's zero [m], shape `(N, W)`
    count: Array  # way of one count of each wheel [m], shape `(W,)`
    radius: Array  # radius of each wheel [m], shape `(W,)`
    wheelbase: Array  # distance between the wheels of each truck [m], shape `(T,)`
    # readings of joint_a [rad], joint_b [rad] and the link's length [m], shape `(N, 3)`; no columns with a
    # single truck
    reading: Array
    rest: float  # length at which the link reads its zero [m]
    poses: dict[int, Poses]  # measured poses of each truck, by its number; trucks without any are absent
    # motion of each truck that its wheels do not make, in its own frame: forward [m], left [m], yaw [rad] in
    # each step, shape `(N - 1, T, 3)`; or None for none
    more: Array | None = None

    @property
    def trucks(self) -> int:
        return len(self.wheelbase)

    def with_way(self, wheel: int, way: Array) -> Self:
        """Return the drive with another way `(N,)` of one wheel [m]."""
        changed = self.way.copy()
        changed[:, wheel] = way
        return replace(self, way=changed)

    def with_reading(self, channel: int, reading: Array) -> Self:
        """Return the drive with another reading `(N,)` of the linkage [rad, m]."""
        changed = self.reading.copy()
        changed[:, channel] = reading
        return replace(self, reading=changed)

    def with_more(self, truck: int, more: Array) -> Self:
        """Return the drive with motion `(N - 1, 3)` added to that of one truck [m, m, rad]."""
        changed = np.zeros((len(self.time) - 1, self.trucks, 3)) if self.more is None else self.more.copy()
        changed[:, truck] += more
        return replace(self, more=changed)

    def speed(self, wheel: int) -> Array:
        """Return the size of a wheel's speed in each step [m/s], shape `(N - 1,)`."""
        return np.abs(rates(self.way[:, wheel], self.time)[0])

    def twist(self, truck: int) -> Array:
        """Return a truck's motion in each step, `(N - 1, 3)`: forward [m], left [m], yaw [rad]."""
        left, right = np.diff(self.way[:, 2 * truck : 2 * truck + 2], axis=0).T
        yaw = (right - left) / self.wheelbase[truck]
        twist = np.stack([0.5 * (left + right), np.zeros_like(yaw), yaw], axis=1)
        return twist if self.more is None else np.asarray(twist + self.more[:, truck])

    def path(self, truck: int) -> Array:
        """Return a truck's dead reckoning from the origin [m, m, rad], shape `(N, 3)`."""
        twist = self.twist(truck)
        chord = twist[:, :2] * np.sinc(twist[:, 2] / (2.0 * np.pi))[:, None]
        heading = np.concatenate(([0.0], np.cumsum(twist[:, 2])))
        steps = turned(heading[:-1] + 0.5 * twist[:, 2], chord)
        return np.column_stack([np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0))), heading])


def turned(angle: Array, vector: Array) -> Array:
    """Return vectors `(K, 2)` turned by angles `(K,)` [rad]."""
    cosine, sine, (x, y) = np.cos(angle), np.sin(angle), vector.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)


def increments(path: Array) -> Array:
    """Return the motion from each pose of a path `(K, 3)` to the next, in its frame, `(K - 1, 3)`."""
    steps = np.diff(path, axis=0)
    return np.column_stack([turned(-path[:-1, 2], steps[:, :2]), steps[:, 2]])


def rates(way: Array, time: Array) -> tuple[Array, Array]:
    """Return speed [m/s] and acceleration [m/s^2] in each step, shape `(N - 1,)`, of a way `(N,)` [m]."""
    period = float(np.median(np.diff(time)))
    half, index = max(1, round(0.5 * SMOOTHING / period)), np.arange(len(time))
    before, after = np.maximum(index - half, 0), np.minimum(index + half, len(time) - 1)
    span = time[after] - time[before]
    speed = (way[after] - way[before]) / span
    acceleration = (speed[after] - speed[before]) / span
    return 0.5 * (speed[1:] + speed[:-1]), 0.5 * (acceleration[1:] + acceleration[:-1])


WINDOW = 0.1  # [s] from one reading, or one pose, to the next that is used; short against any manoeuvre


def residual(drive: Drive) -> dict[str, Array]:
    """Return what dead reckoning misses, by what was read.

    `linkage`: joint_a [rad], joint_b [rad] and link [m] at the end of each window, shape `(K, 3)`, absent
    with a single truck; `a` and `b`: forward [m], left [m] and yaw [rad] from pose to pose of the truck,
    shape `(M - 1, 3)`, absent where there are fewer than two poses.
    """
    paths = [drive.path(truck) for truck in range(drive.trucks)]
    missed = {}
    if drive.reading.shape[1]:
        missed["linkage"] = _of_linkage(drive, paths)
    for truck, poses in drive.poses.items():
        rows = spaced(poses.time)
        if len(rows) > 1:
            at = poses.time[rows]
            reckoned = np.stack([np.interp(at, drive.time, axis) for axis in paths[truck].T], axis=1)
            missed["ab"[truck]] = increments(reckoned) - increments(poses.pose[rows])
    return missed


def spaced(time: Array) -> NDArray[np.int64]:
    """Return the rows of times `(N,)` that are a window or more apart."""
    if len(time) < 2:
        return np.arange(len(time))
    period = float(np.median(np.diff(time)))
    return np.arange(0, len(time), max(1, round(WINDOW / period)))


def _of_linkage(drive: Drive, paths: list[Array]) -> Array:
    rows = spaced(drive.time)
    begin, end = drive.reading[rows[:-1]], drive.reading[rows[1:]]
    ahead, behind = (increments(path[rows]) for path in paths)
    # the link lies along x, its end on truck b in the origin
    lead = turned(begin[:, 0], ahead[:, :2])
    follow = turned(begin[:, 1], behind[:, :2])
    gap = lead - follow
    gap[:, 0] += begin[:, 2]
    along = np.arctan2(gap[:, 1], gap[:, 0])
    expected = np.stack(
        [
            begin[:, 0] + ahead[:, 2] - along,
            begin[:, 1] + behind[:, 2] - along,
            np.hypot(gap[:, 0], gap[:, 1]),
        ],
        axis=1,
    )
    missed = expected - end
    missed[:, :2] = (missed[:, :2] + np.pi) % (2.0 * np.pi) - np.pi
    return missed


STEP = 1e-4  # relative step of a calibration's number, small against the wavelength of any path
FEWEST = 15  # periodogram values in a mean; the spectrum then scatters by a quarter, a strength by an eighth
FEW = 40  # values in which no correlation can be seen


@dataclass(frozen=True, slots=True)
class Noise:
    """The noise of some recordings of one robot."""

    # frequency in cycles per value, and power spectrum, of each column of each part of the residual, both
    # ascending
    spectra: Mapping[tuple[str, int], tuple[Array, Array]]

    @classmethod
    def of(cls, residuals: Sequence[Residual]) -> Noise:
        """Return the noise in the residuals of recordings."""
        parts = sorted(set().union(*residuals))
        return cls(
            {
                (part, column): _spectrum(
                    [residual[part][:, column] for residual in residuals if part in residual]
                )
                for part in parts
                for column in range(3)
            }
        )

    def whitened(self, changes: Sequence[Residual]) -> Array:
        """Return changes of residuals as one vector in units of the noise, W' D, shape `(K,)`."""
        return np.concatenate(
            [
                self._whitened(change[part][:, column], self.spectra[part, column])
                for change in changes
                for part in sorted(change)
                for column in range(3)
            ]
        )

    @staticmethod
    def _whitened(change: Array, spectrum: tuple[Array, Array]) -> Array:
        count, at = len(change), np.fft.rfftfreq(len(change))
        twice = np.where((at > 0.0) & (at < 0.5), 2.0, 1.0)  # rfft leaves out the negative frequencies
        scaled = np.fft.rfft(change) * np.sqrt(twice / (count * np.interp(at, *spectrum)))
        return np.concatenate((scaled.real, scaled.imag))


def _spectrum(series: Sequence[Array]) -> tuple[Array, Array]:
    if sum(map(len, series)) < FEW:
        return np.array([0.0]), np.array([np.mean(np.concatenate(series) ** 2)])
    frequency = np.concatenate([np.fft.rfftfreq(len(values)) for values in series])
    power = np.concatenate([np.abs(np.fft.rfft(values)) ** 2 / len(values) for values in series])
    order = np.argsort(frequency, kind="stable")
    width = min(FEWEST * len(series), len(order))
    sums = np.cumsum(np.concatenate(([0.0], power[order])))
    begin = np.clip(np.arange(len(order)) - width // 2, 0, len(order) - width)
    return frequency[order], (sums[begin + width] - sums[begin]) / width


@dataclass(frozen=True, slots=True)
class Ruler:
    """Measures how strong changes of some recordings are."""

    noise: Noise  # noise of the untouched recordings
    untouched: tuple[Residual, ...]  # their residuals

    @classmethod
    def of(cls, drives: Sequence[Drive]) -> Ruler:
        """Return the ruler of untouched recordings of one robot."""
        untouched = tuple(residual(drive) for drive in drives)
        return cls(Noise.of(untouched), untouched)

    def change(self, drives: Sequence[Drive]) -> Array:
        """Return the whitened change of the residuals in altered recordings, W' D, shape `(K,)`."""
        pairs = [(residual(drive), before) for drive, before in zip(drives, self.untouched, strict=True)]
        return self.noise.whitened(
            [{part: after[part] - before[part] for part in before} for after, before in pairs]
        )

    def nuisances(self, drives: Sequence[Drive], effect: str = "", component: str = "") -> list[Array]:
        """Return the changes `(K,)` by the numbers of a calibration, but for the one that an effect is."""
        trucks, key = drives[0].trucks, (effect, component)
        numbers: list[tuple[Callable[[Drive, int], Drive], int]]
        numbers = [(_wider, truck) for truck in range(trucks) if key != ("wheelbase", TRUCKS[truck])]
        numbers += [
            (_larger, wheel) for wheel in range(2 * trucks) if key != ("wheel_diameter", WHEELS[wheel])
        ]
        return [self.change([larger(drive, place) for drive in drives]) / STEP for larger, place in numbers]


def _wider(drive: Drive, truck: int) -> Drive:
    base = drive.wheelbase.copy()
    base[truck] *= 1.0 + STEP
    return replace(drive, wheelbase=base)


def _larger(drive: Drive, wheel: int) -> Drive:
    way = drive.way[:, wheel]
    return drive.with_way(wheel, way[0] + (1.0 + STEP) * (way - way[0]))


def left_of(change: Array, explained_by: Sequence[Array]) -> float:
    """Return the norm of what is left of a change `(K,)` when others `(K,)` have taken their best part."""
    others = [other / size for other in explained_by if (size := float(np.linalg.norm(other))) > 0.0]
    if not others:
        return float(np.linalg.norm(change))
    columns = np.stack(others, axis=1)
    share, *_ = np.linalg.lstsq(columns, change, rcond=1e-9)
    return float(np.linalg.norm(change - columns @ share))
