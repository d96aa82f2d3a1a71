"""The noise levels of a recording, estimated from itself: files state none.

Restricted maximum likelihood over the levels, with the smooth effects of the library integrated out, so
that physics left out is not taken for noise, nor noise for physics. A priori each level is known within a
factor, from robots that work; the factors are wide, and only keep a level that the recording says nothing
about in bounds.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize

from omnimate.mismatch.noise.whitening import adjoint, gains_of, whiten, whiten_travel
from omnimate.mismatch.recording.signals import START_ROUGHNESS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

LOOSE = 0.3  # [m, rad] of the first poses, before anything is measured
# A level is known a priori within a factor of exp(1.2) = 3.3; what a file states of its poses, within 2.
_FREEDOM = np.array([1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 0.7, 0.7, 1.2])
# Beyond these no level is looked for [log]: no floor or sensor in use is three times better than an ordinary
# one, and what is fifty times worse is a fault.
_LEAST, _MOST = math.log(3.0), math.log(50.0)
WAVES = (0.05, 0.15)  # [m] lengths of the floor's waves: from joints of tiles to a wheel's length of contact
FINE, ROUGH = 1e-5, 5e-3  # part of the log likelihood by which a turn must raise it, or the search ends
_CHUNK = 48  # columns that go through a filter together
_TIDE = 1e-7  # [m^2, rad^2] per window: what the model's linearity may miss


@dataclass(frozen=True, slots=True)
class NoiseLevels:
    """Standard deviations.

    Attributes:
        roughness: of a wheel's travel, from window to window [m/sqrt(m)].
        waviness: likewise, of what is alike along a correlation length [m/sqrt(m)].
        wave: correlation length of the floor's waves [m].
        creep: of a truck's sideways motion [m/sqrt(m)].
        joint_a: of a reading, beyond its resolution [rad].
        joint_b: likewise [rad].
        link: likewise [m].
        position: factor on the stated sigma of measured positions.
        heading: factor on the stated sigma of measured headings.
        sway: of a truck on its tyres while it rolls, at each wheel and sideways [m/sqrt(s)].
    """

    roughness: float = START_ROUGHNESS
    waviness: float = 1e-4
    wave: float = 0.15
    creep: float = 1e-4
    joint_a: float = 2e-4
    joint_b: float = 2e-4
    link: float = 1e-4
    position: float = 1.0
    heading: float = 1.0
    sway: float = 3e-5

    def levels(self) -> Array:
        """Return the logarithms of the levels, `(10,)`."""
        return np.asarray(np.log(list(asdict(self).values())))

    def named(self) -> dict[str, float]:
        """Return the levels by name and unit."""
        units = ("m/sqrt(m)", "m/sqrt(m)", "m", "m/sqrt(m)", "rad", "rad", "m", "1", "1", "m/sqrt(s)")
        return {
            f"{name} [{unit}]": value for (name, value), unit in zip(asdict(self).items(), units, strict=True)
        }


DEFAULT_LEVELS = NoiseLevels()


@dataclass(frozen=True, slots=True)
class Filter:
    """One recording's filter at given levels of noise.

    Attributes:
        windows: the linear model.
        transition: (M, n, n) with the floor's waves in it.
        gains: (M + 1, R, n).
        spread: (M + 1, R) variances of the innovations; nan where nothing was measured.
    """

    windows: Windows
    transition: Array
    gains: Array
    spread: Array

    def whiten(self, inputs: Array, measured: Array) -> Array:
        """Return the whitened innovations (V, C) of columns, in the rows that were measured.

        Args:
            inputs: (M, 3 T, C).
            measured: (M + 1, R, C).
        """
        return whiten(
            self.transition,
            self.windows.links,
            np.ascontiguousarray(inputs),
            self.windows.observe,
            np.ascontiguousarray(measured),
            self.gains,
            self.spread,
        )

    def whiten_travel(self, wheel: int, ways: Array) -> Array:
        """Return the whitened innovations (V, C) of columns of ways (M, C) that a wheel gains [m]."""
        windows = self.windows
        white = [
            whiten_travel(
                self.transition,
                windows.links,
                -windows.lever[:, wheel, : windows.drift.shape[1]],
                np.ascontiguousarray(some),
                windows.observe,
                self.gains,
                self.spread,
            )
            for some in np.split(ways, range(_CHUNK, ways.shape[1], _CHUNK), axis=1)
        ]
        return np.hstack(white)


def filter_of(windows: Windows, noise: NoiseLevels) -> Filter:
    """Return one recording's filter at given levels of noise."""
    transition, start = windows.transition.copy(), start_of(windows)
    waves = _waves(windows)
    kept, mean = _wave(windows, noise.wave)
    transition[:, waves, waves] = kept
    start[waves, waves] = noise.waviness**2 * mean.max(axis=0)
    gains, spread = gains_of(
        transition,
        windows.links,
        _process(windows, noise, kept, mean),
        windows.observe,
        variance_of(windows, noise),
        start,
    )
    return Filter(windows, transition, gains, spread)


def _process(windows: Windows, noise: NoiseLevels, kept: Array, mean: Array) -> Array:
    """Return the process covariances (M, n, n)."""
    process = windows.rounding.copy()
    poses = windows.floor.shape[1]
    process[:, :poses, :poses] += noise.roughness**2 * windows.floor + noise.creep**2 * windows.creep
    process[:, :poses, :poses] += noise.sway**2 * windows.sway
    moving = windows.rolled.sum(axis=1) > 0.0
    process[:, range(poses), range(poses)] += (_TIDE**2) * moving[:, None]
    waves = _waves(windows)
    process[:, waves, waves] = noise.waviness**2 * mean * (1.0 - kept**2)
    return np.asarray(process)


def _waves(windows: Windows) -> NDArray[np.int64]:
    """Return the numbers of the states that are the floor's waves."""
    states = windows.transition.shape[1]
    return np.arange(states - windows.rolled.shape[1], states)


def _wave(windows: Windows, length: float) -> tuple[Array, Array]:
    """Return which part (M, W) of a wave is kept in each window, and its mean square in it.

    The latter is of an Ornstein-Uhlenbeck process' mean over the window's way, of unit long-run size.
    """
    ratio = windows.rolled / length
    kept = np.exp(-ratio)
    mean = np.where(ratio > 1e-3, (ratio - 1.0 + kept) / np.maximum(ratio, 1e-3) ** 2, 0.5) / length
    return kept, mean


def variance_of(windows: Windows, noise: NoiseLevels) -> Array:
    """Return the variances (M + 1, R) of what was measured; nan where nothing was."""
    variance = np.empty(windows.measured.shape)
    own = windows.linkage
    if own:
        variance[:, :3] = np.array([noise.joint_a, noise.joint_b, noise.link]) ** 2 + windows.stated[:, :3]
    factors = np.tile([noise.position, noise.position, noise.heading], len(windows.signals.trucks))
    variance[:, own:] = windows.stated[:, own:] * factors**2
    return np.where(np.isfinite(windows.measured), variance, np.nan)


def start_of(windows: Windows) -> Array:
    """Return the covariance of the first state: without poses truck a stands where we say."""
    signals = windows.signals
    states = windows.transition.shape[1]
    trucks = 3 * len(signals.trucks)
    start = np.zeros((states, states))
    first = 0 if signals.poses is not None else 3
    start[range(first, trucks), range(first, trucks)] = LOOSE**2
    linkage = range(trucks, trucks + windows.linkage)
    start[linkage, linkage] = signals.resolution**2 / 12.0
    vehicle = signals.recording.vehicle
    wheels = range(trucks + windows.linkage, trucks + windows.linkage + len(vehicle.wheels))
    start[wheels, wheels] = [vehicle.metres_per_count(wheel) ** 2 / 12.0 for wheel in vehicle.wheels]
    return start


def estimate_noise(
    windows: Sequence[Windows],
    columns: Sequence[tuple[Array, Array]],
    start: NoiseLevels | None = None,
    waves: Sequence[float] = WAVES,
    tolerance: float = FINE,
) -> NoiseLevels:
    """Return the levels that make recordings likeliest, with all columns but the first as nuisances.

    The likelihood's derivatives are exact: the disturbance smoother gives them in one pass.

    Args:
        windows: Of each recording.
        columns: Of each recording inputs (M, 3 T, C) and measurements (M + 1, R, C): the data, then the
            nuisances in units of their scale.
        start: From which to look; robots that work by default.
        waves: Lengths of the floor's waves that are tried [m].
        tolerance: Part of the log likelihood by which a turn of the search must raise it.
    """
    centre = usual_levels(windows)
    guess = centre if start is None else start
    best, lowest = guess, math.inf
    for wave in waves:
        levels, cost = _likeliest(windows, columns, replace(guess, wave=wave), centre, tolerance)
        if cost < lowest:
            best, lowest = levels, cost
    return best


def _likeliest(
    windows: Sequence[Windows],
    columns: Sequence[tuple[Array, Array]],
    guess: NoiseLevels,
    centre: NoiseLevels,
    tolerance: float,
) -> tuple[NoiseLevels, float]:
    """Return the likeliest levels at one length of waves, and minus their log posterior."""
    active = np.array(_active(windows))
    middle, fixed = centre.levels()[active], guess.levels()

    def at(free: Array) -> NoiseLevels:
        levels = fixed.copy()
        levels[active] = free
        return NoiseLevels(*np.exp(levels).tolist())

    def badness(free: Array) -> tuple[float, Array]:
        cost, slope = _badness(windows, columns, at(free))
        away = (free - middle) / _FREEDOM[active]
        return cost + 0.5 * float(away @ away), slope[active] + away / _FREEDOM[active]

    found = minimize(
        badness,
        np.clip(fixed[active], middle - _LEAST, middle + _MOST),
        jac=True,
        method="L-BFGS-B",
        bounds=[(level - _LEAST, level + _MOST) for level in middle],
        options={"maxiter": 20, "ftol": tolerance},
    )
    return at(found.x), float(found.fun)


def _badness(
    windows: Sequence[Windows], columns: Sequence[tuple[Array, Array]], noise: NoiseLevels
) -> tuple[float, Array]:
    """Return minus the log likelihood, nuisances integrated out, and its slopes (10,) by the log levels.

    Levels are then not too small where nuisances take many of few readings (Harville, JASA 1977).
    """
    runs = [filter_of(single, noise) for single in windows]
    width = columns[0][0].shape[2]
    cost, gram = 0.0, np.zeros((width, width))
    whites = []
    for run, raw in zip(runs, columns, strict=True):
        there = np.isfinite(run.spread)
        cost += 0.5 * float(np.log(run.spread[there]).sum())
        whites.append(run.whiten(*raw))
        gram += whites[-1].T @ whites[-1]
    precision = gram[1:, 1:] + np.eye(width - 1)
    fitted = np.concatenate(([1.0], -np.linalg.solve(precision, gram[1:, 0])))
    cost += 0.5 * float(fitted @ gram @ fitted) + 0.5 * float(fitted[1:] @ fitted[1:])
    root = np.linalg.cholesky(precision)
    cost += float(np.log(np.diagonal(root)).sum())
    apart = np.zeros((width, width))  # what is left of the data, and the nuisances with all that is not known
    apart[:, 0], apart[1:, 1:] = fitted, np.linalg.inv(root).T
    slope = np.zeros(len(_FREEDOM))
    for run, white in zip(runs, whites, strict=True):
        slope -= _slopes(run, noise, white @ apart)
    return cost, slope


def _slopes(run: Filter, noise: NoiseLevels, white: Array) -> Array:
    """Return the slopes (10,) of one recording's log likelihood by the logarithms of levels.

    Args:
        run: Of it.
        noise: The levels.
        white: Whitened columns that are summed over, (V, C).
    """
    windows = run.windows
    scores, informations, by_variance = adjoint(
        run.transition, windows.links, windows.observe, run.gains, run.spread, white
    )
    poses, waves = windows.floor.shape[1], _waves(windows)
    shoved = scores[:, :poses]
    half = 0.5 * (shoved @ shoved.transpose(0, 2, 1) - informations[:, :poses, :poses])
    waved = 0.5 * ((scores[:, waves] ** 2).sum(axis=2) - informations[:, waves, waves])
    slope = np.zeros(len(_FREEDOM))
    slope[0] = 2.0 * noise.roughness**2 * float(np.vdot(half, windows.floor))
    kept, mean = _wave(windows, noise.wave)
    slope[1] = 2.0 * noise.waviness**2 * float((waved * mean * (1.0 - kept**2)).sum())
    slope[3] = 2.0 * noise.creep**2 * float(np.vdot(half, windows.creep))
    own = windows.linkage
    variance = variance_of(windows, noise)
    by_variance = np.where(np.isfinite(variance), by_variance, 0.0)
    for row, level in enumerate((noise.joint_a, noise.joint_b, noise.link)[:own]):
        slope[4 + row] = 2.0 * level**2 * float(by_variance[:, row].sum())
    measured = 2.0 * np.where(np.isfinite(variance), variance, 0.0) * by_variance
    heading = np.arange(own, measured.shape[1])
    slope[7] = float(measured[:, heading[(heading - own) % 3 < 2]].sum())
    slope[8] = float(measured[:, heading[(heading - own) % 3 == 2]].sum())
    slope[9] = 2.0 * noise.sway**2 * float(np.vdot(half, windows.sway))
    return slope


def usual_levels(windows: Sequence[Windows]) -> NoiseLevels:
    """Return the levels of a usual robot with the resolution of this one's encoders."""
    resolution = windows[0].signals.resolution
    if len(resolution) == 0:
        return NoiseLevels()
    joint_a, joint_b, link = (0.3 * resolution).tolist()
    return replace(
        NoiseLevels(), joint_a=max(joint_a, 2e-5), joint_b=max(joint_b, 2e-5), link=max(link, 1e-5)
    )


def _active(windows: Sequence[Windows]) -> list[bool]:
    """Say which levels recordings can tell anything about."""
    linkage = windows[0].linkage > 0
    poses = any(one.signals.poses is not None for one in windows)
    return [
        True,
        linkage or poses,
        False,
        linkage or poses,
        linkage,
        linkage,
        linkage,
        poses,
        poses,
        linkage or poses,
    ]
