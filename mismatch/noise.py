"""The noise levels of a recording, estimated from itself: files state none.

Restricted maximum likelihood over the levels, with the smooth effects of the library as nuisances, so
that physics left out is not taken for noise. A priori each level is known within a factor, from robots
that work; the factors are wide, and only keep a level that the recording says nothing about in bounds.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize

from omnimate.mismatch.signals import START_ROUGHNESS
from omnimate.mismatch.whitening import gains_of, whiten

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.se2 import Array

STILL = 1e-9  # [m/sqrt(m)] of waves that are none: the floor is white, and stays so
LOOSE = 0.3  # [m, rad] of the first poses, before anything is measured
# A level is known a priori within a factor of exp(1.2) = 3.3; what a file states of its poses, within 2.
_FREEDOM = np.array([1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 0.7, 0.7])
# Beyond such a factor no level is believed; waves that are longer would be taken for wheels that change.
_WIDEST = np.array([4.0, 4.0, 1.2, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0])
# Nor does any reading err by much less than its resolution: below, the likelihood is flat, and a search
# that came there once would never come back.
_LEAST = np.array([4.0, 4.0, 1.2, 4.0, 1.2, 1.2, 1.2, 4.0, 4.0])
_RAISED = 0.7  # [log] of all levels, from where a search that got stuck is begun anew
_NEAR = 0.01  # [log] of a bound
_ENOUGH = 0.03  # by which a row's mean chi-square may be above one at the best levels
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

    def levels(self) -> Array:
        """Return the logarithms of the levels, `(9,)`."""
        return np.asarray(np.log(list(asdict(self).values())))

    def named(self) -> dict[str, float]:
        """Return the levels by name and unit."""
        units = ("m/sqrt(m)", "m/sqrt(m)", "m", "m/sqrt(m)", "rad", "rad", "m", "1", "1")
        return {
            f"{name} [{unit}]": value for (name, value), unit in zip(asdict(self).items(), units, strict=True)
        }


DEFAULT_LEVELS = NoiseLevels()
WHITE_FLOOR = NoiseLevels(waviness=STILL)


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
        """Return the whitened innovations (M + 1, R, C) of columns.

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


def filter_of(windows: Windows, noise: NoiseLevels) -> Filter:
    """Return one recording's filter at given levels of noise."""
    process = noise.roughness**2 * windows.floor + noise.creep**2 * windows.creep + windows.rounding
    trucks = 3 * len(windows.signals.trucks)
    moving = windows.rolled.sum(axis=1) > 0.0
    process[:, range(trucks), range(trucks)] += (_TIDE**2) * moving[:, None]
    transition, start = windows.transition.copy(), start_of(windows)
    waves = np.arange(process.shape[1] - windows.rolled.shape[1], process.shape[1])
    ratio = windows.rolled / noise.wave
    kept = np.exp(-ratio)
    # variance of an Ornstein-Uhlenbeck process' mean over a window's way, of unit long-run size
    mean = np.where(ratio > 1e-3, (ratio - 1.0 + kept) / np.maximum(ratio, 1e-3) ** 2, 0.5) / noise.wave
    transition[:, waves, waves] = kept
    process[:, waves, waves] = noise.waviness**2 * mean * (1.0 - kept**2)
    start[waves, waves] = noise.waviness**2 * mean.max(axis=0)
    gains, spread = gains_of(
        transition, windows.links, process, windows.observe, variance_of(windows, noise), start
    )
    return Filter(windows, transition, gains, spread)


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
    windows: Sequence[Windows], columns: Sequence[tuple[Array, Array]], start: NoiseLevels | None = None
) -> NoiseLevels:
    """Return the levels that make recordings likeliest, with all columns but the first as nuisances.

    Args:
        windows: of each recording.
        columns: of each recording inputs (M, 3 T, C) and measurements (M + 1, R, C): the data, then the
            nuisances in units of their scale.
        start: from which to look; robots that work by default.
    """
    guess = _first_guess(windows) if start is None else start
    centre = _first_guess(windows).levels()
    active = np.array(_active(windows))
    active[1:3] &= guess.waviness > STILL

    def badness(free: Array) -> tuple[float, float]:
        """Return minus the log likelihood, and the chi-square that is left for each row."""
        levels = guess.levels()
        levels[active] = free
        noise = NoiseLevels(*np.exp(levels).tolist())
        cost, rows, gram = 0.0, 0, np.zeros((columns[0][0].shape[2],) * 2)
        for one, own in zip(windows, columns, strict=True):
            run = filter_of(one, noise)
            there = np.isfinite(run.spread)
            cost += 0.5 * float(np.log(run.spread[there]).sum())
            white = run.whiten(*own).reshape(-1, len(gram))
            gram += white.T @ white
            rows += int(there.sum())
        precision = gram[1:, 1:] + np.eye(len(gram) - 1)
        left = float(gram[0, 0] - gram[0, 1:] @ np.linalg.solve(precision, gram[1:, 0]))
        away = (free - centre[active]) / _FREEDOM[active]
        cost += 0.5 * left + 0.5 * float(np.linalg.slogdet(precision)[1]) + 0.5 * float(away @ away)
        return cost, left / rows

    def cost_of(free: Array) -> float:
        return badness(free)[0]

    least, most = (centre - _LEAST)[active], (centre + _WIDEST)[active]
    best, lowest = guess.levels()[active], math.inf
    for start_levels in (best, centre[active] + _RAISED):
        found = minimize(
            cost_of,
            np.clip(start_levels, least, most),
            method="L-BFGS-B",
            bounds=list(zip(least, most, strict=True)),
            options={"maxiter": 25, "eps": 1e-3, "ftol": 1e-5},
        )
        if found.fun < lowest:
            best, lowest = found.x, found.fun
        if not np.any(best <= least + _NEAR) or badness(best)[1] < 1.0 + _ENOUGH:
            break  # else a level may have been driven to its bound by a step that was too long
    levels = guess.levels()
    levels[active] = best
    return NoiseLevels(*np.exp(levels).tolist())


def _first_guess(windows: Sequence[Windows]) -> NoiseLevels:
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
        linkage or poses,
        linkage or poses,
        linkage,
        linkage,
        linkage,
        poses,
        poses,
    ]
