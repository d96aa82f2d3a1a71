"""Noise levels of a recording, estimated from the recording itself: its files state none.

Restricted maximum likelihood over the levels, with the smooth effects of the library integrated out, so
that missing physics is not taken for noise, nor noise for physics. A wide prior about the levels of nominal
robots bounds those that the recording does not identify.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize

from omnimate.mismatch.noise.whitening import adjoint, gains_of, whiten
from omnimate.mismatch.recording.signals import START_ROUGHNESS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

START_SIGMA = 0.3  # [m, rad] standard deviation of the first poses, before anything is measured
# [1] prior standard deviations of the logarithms of the levels, in the order of `NoiseLevels`: a factor of
# exp(1.2) = 3.3, and of exp(0.7) = 2 about what a file states of its poses. Assumed, not estimated.
LOG_LEVEL_SIGMA = np.array([1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 1.2, 0.7, 0.7, 1.2])
# [1] largest factors below and above the nominal level: no floor or sensor in use is three times better than
# a nominal one, and one that is fifty times worse is faulty.
MAX_BELOW, MAX_ABOVE = math.log(3.0), math.log(50.0)
WAVES = (0.05, 0.15)  # [m] correlation lengths of the floor: a wheel's contact length, and joints of tiles
FINE, ROUGH = 1e-5, 5e-3  # [1] relative rise of the log likelihood below which the search ends
_CHUNK = 48  # columns that go through a filter together: those of late events then skip its beginning
LINEARISATION_NOISE = 1e-7  # [m, rad] standard deviation per window of what the linear model omits


@dataclass(frozen=True, slots=True)
class NoiseLevels:
    """Standard deviations."""

    roughness: float = START_ROUGHNESS  # of a wheel's travel, independent from window to window [m/sqrt(m)]
    waviness: float = 1e-4  # of a wheel's travel, correlated along the floor [m/sqrt(m)]
    wave: float = 0.15  # correlation length of the floor's waves [m]
    creep: float = 1e-4  # of a truck's sideways motion [m/sqrt(m)]
    joint_a: float = 2e-4  # of a reading, in addition to its resolution [rad]
    joint_b: float = 2e-4  # likewise [rad]
    link: float = 1e-4  # likewise [m]
    position: float = 1.0  # factor on the stated sigma of measured positions
    heading: float = 1.0  # factor on the stated sigma of measured headings
    sway: float = 3e-5  # of a truck on its tyres while it rolls, at each wheel and sideways [m/sqrt(s)]

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
    """Kalman filter of one recording at given noise levels."""

    windows: Windows  # the linear model
    transition: Array  # with the decay of the floor's waves, `(M, n, n)`
    gains: Array  # of each measurement, `(M + 1, R, n)`
    spread: Array  # variances of the innovations; nan where nothing was measured, `(M + 1, R)`

    def whiten(self, inputs: Array, measured: Array) -> Array:
        """Return the whitened innovations (V, C) of inputs (M, 3 T, C) and measurements (M + 1, R, C)."""
        return whiten(
            self.transition,
            self.windows.links,
            np.ascontiguousarray(inputs),
            self.windows.observe,
            np.ascontiguousarray(measured),
            self.gains,
            self.spread,
        )

    def whiten_travel(self, wheel: int, travel: Array) -> Array:
        """Return the whitened innovations (V, C) of additional travel (M, C) of a wheel [m]."""
        lever = -self.windows.lever[:, wheel, : self.windows.drift.shape[1], None]
        measured = np.zeros((*self.windows.measured.shape, _CHUNK))
        parts = np.split(travel, range(_CHUNK, travel.shape[1], _CHUNK), axis=1)
        return np.hstack(
            [self.whiten(lever * part[:, None], measured[..., : part.shape[1]]) for part in parts]
        )


def filter_of(windows: Windows, noise: NoiseLevels) -> Filter:
    """Return the Kalman filter of one recording at given noise levels."""
    transition, process, start = _motion(windows, noise)
    variance = variance_of(windows, noise)
    gains, spread = gains_of(transition, windows.links, process, windows.observe, variance, start)
    return Filter(windows, transition, gains, spread)


def open_loop_variance(windows: Windows, noise: NoiseLevels, edges: Sequence[int]) -> Array:
    """Return the variances (E - 1, R) of what is measured open loop where stretches end.

    The noise of the sensors at both ends is in them. Stretches begin and end, with a known state, at the
    windows' ends `edges` (E,).
    """
    transition, process, start = _motion(windows, noise)
    known = start * 0.0
    waves = _wave_states(windows)
    known[waves, waves] = start[waves, waves]
    variances = []
    for first, last in itertools.pairwise(edges):
        covariance = known
        for step, disturbed in zip(transition[first:last], process[first:last], strict=True):
            covariance = step @ covariance @ step.T + disturbed
        observe = windows.observe[last]
        variances.append(np.einsum("ri,ij,rj->r", observe, covariance, observe))
    variance = np.nan_to_num(variance_of(windows, noise)[np.asarray(edges, np.int64)])
    return np.asarray(np.array(variances).reshape(-1, variance.shape[1]) + variance[1:] + variance[:-1])


def _motion(windows: Windows, noise: NoiseLevels) -> tuple[Array, Array, Array]:
    """Return transitions and process covariances, `(M, n, n)`, and the covariance of the start, `(n, n)`."""
    transition, process = windows.transition.copy(), windows.rounding.copy()
    start, poses, waves = _start_covariance(windows), windows.floor.shape[1], _wave_states(windows)
    decay, mean_square = _wave_moments(windows, noise.wave)
    transition[:, waves, waves] = decay
    start[waves, waves] = noise.waviness**2 * mean_square.max(axis=0)
    process[:, :poses, :poses] += noise.roughness**2 * windows.floor + noise.creep**2 * windows.creep
    process[:, :poses, :poses] += noise.sway**2 * windows.sway
    moving = windows.rolled.sum(axis=1) > 0.0
    process[:, range(poses), range(poses)] += LINEARISATION_NOISE**2 * moving[:, None]
    process[:, waves, waves] = noise.waviness**2 * mean_square * (1.0 - decay**2)
    return transition, process, start


def _wave_states(windows: Windows) -> NDArray[np.int64]:
    """Return the numbers of the states that are the floor's waves, `(W,)`."""
    states = windows.transition.shape[1]
    return np.arange(states - windows.rolled.shape[1], states)


def _wave_moments(windows: Windows, length: float) -> tuple[Array, Array]:
    """Return the decay (M, W) of the floor's waves in each window, and the mean square of their mean in it.

    They are Ornstein-Uhlenbeck processes along each wheel's travel, of unit variance per metre. Their
    correlation length is in metres.
    """
    ratio = windows.rolled / length
    decay = np.exp(-ratio)
    mean_square = np.where(ratio > 1e-3, (ratio - 1.0 + decay) / np.maximum(ratio, 1e-3) ** 2, 0.5) / length
    return decay, mean_square


def variance_of(windows: Windows, noise: NoiseLevels) -> Array:
    """Return the variances (M + 1, R) of what was measured; nan where nothing was."""
    variance = np.empty(windows.measured.shape)
    linkage = windows.linkage
    if linkage:
        variance[:, :3] = np.array([noise.joint_a, noise.joint_b, noise.link]) ** 2 + windows.stated[:, :3]
    factors = np.tile([noise.position, noise.position, noise.heading], len(windows.signals.trucks))
    variance[:, linkage:] = windows.stated[:, linkage:] * factors**2
    return np.where(np.isfinite(windows.measured), variance, np.nan)


def _start_covariance(windows: Windows) -> Array:
    """Return the covariance (n, n) of the first state; without poses truck a defines the origin."""
    signals, vehicle = windows.signals, windows.signals.recording.vehicle
    variance = np.zeros(windows.transition.shape[1])
    trucks = 3 * len(signals.trucks)
    variance[0 if signals.poses is not None else 3 : trucks] = START_SIGMA**2
    counts = [vehicle.metres_per_count(wheel) for wheel in vehicle.wheels]
    rounded = np.concatenate([signals.resolution, counts]) ** 2 / 12.0
    variance[trucks : trucks + len(rounded)] = rounded
    return np.diag(variance)


def estimate_noise(
    windows: Sequence[Windows],
    columns: Sequence[tuple[Array, Array]],
    start: NoiseLevels | None = None,
    waves: Sequence[float] = WAVES,
    tolerance: float = FINE,
) -> NoiseLevels:
    """Return the levels of maximum posterior density, with all columns but the first as nuisances.

    The derivatives of the likelihood are exact: the disturbance smoother gives them in one pass. `columns`
    are of each recording inputs (M, 3 T, C) and measurements (M + 1, R, C): the data, then the nuisances in
    units of their scale. `waves` are the correlation lengths of the floor's waves to try [m], and `tolerance`
    is the relative rise of the log likelihood below which the search ends.
    """
    nominal = nominal_levels(windows)
    guess = nominal if start is None else start
    candidates = [
        _maximise_posterior(windows, columns, replace(guess, wave=wave), nominal, tolerance) for wave in waves
    ]
    return min(candidates, key=lambda candidate: candidate[1])[0]


def _maximise_posterior(
    windows: Sequence[Windows],
    columns: Sequence[tuple[Array, Array]],
    guess: NoiseLevels,
    nominal: NoiseLevels,
    tolerance: float,
) -> tuple[NoiseLevels, float]:
    """Return the levels of maximum posterior density at the guess's wave length, and minus its logarithm."""
    active = _identifiable(windows)
    centre, fixed = nominal.levels()[active], guess.levels()

    def at(logarithms: Array) -> NoiseLevels:
        levels = fixed.copy()
        levels[active] = logarithms
        return NoiseLevels(*np.exp(levels).tolist())

    def cost_and_slope(logarithms: Array) -> tuple[float, Array]:
        cost, slope = _negative_log_likelihood(windows, columns, at(logarithms))
        deviation = (logarithms - centre) / LOG_LEVEL_SIGMA[active]
        return cost + 0.5 * float(deviation @ deviation), slope[active] + deviation / LOG_LEVEL_SIGMA[active]

    optimum = minimize(
        cost_and_slope,
        np.clip(fixed[active], centre - MAX_BELOW, centre + MAX_ABOVE),
        jac=True,
        method="L-BFGS-B",
        bounds=[(level - MAX_BELOW, level + MAX_ABOVE) for level in centre],
        options={"maxiter": 20, "ftol": tolerance},
    )
    return at(optimum.x), float(optimum.fun)


def _negative_log_likelihood(
    windows: Sequence[Windows], columns: Sequence[tuple[Array, Array]], noise: NoiseLevels
) -> tuple[float, Array]:
    """Return minus the log likelihood, nuisances integrated out, and its slopes (10,) by the log levels.

    Integrating them out keeps levels from being underestimated where nuisances fit a large part of few
    readings (Harville, JASA 1977).
    """
    filters = [filter_of(model, noise) for model in windows]
    whites = [run.whiten(*raw) for run, raw in zip(filters, columns, strict=True)]
    width = columns[0][0].shape[2]
    cost, gram = 0.0, np.zeros((width, width))
    for run, white in zip(filters, whites, strict=True):
        cost += 0.5 * float(np.log(run.spread[np.isfinite(run.spread)]).sum())
        gram += white.T @ white
    precision = gram[1:, 1:] + np.eye(width - 1)
    fitted = np.concatenate(([1.0], -np.linalg.solve(precision, gram[1:, 0])))
    cost += 0.5 * float(fitted @ gram @ fitted) + 0.5 * float(fitted[1:] @ fitted[1:])
    root = np.linalg.cholesky(precision)
    cost += float(np.log(np.diagonal(root)).sum())
    mixing = np.zeros((width, width))  # to the residual, and to a root of the nuisances' posterior covariance
    mixing[:, 0], mixing[1:, 1:] = fitted, np.linalg.inv(root).T
    slope = np.zeros(len(LOG_LEVEL_SIGMA))
    for run, white in zip(filters, whites, strict=True):
        slope -= _slopes(run, noise, white @ mixing)
    return cost, slope


def _slopes(run: Filter, noise: NoiseLevels, white: Array) -> Array:
    """Return slopes (10,) of a recording's log likelihood by log levels, from whitened columns (V, C)."""
    windows = run.windows
    scores, informations, by_variance = adjoint(
        run.transition, windows.links, windows.observe, run.gains, run.spread, white
    )
    poses, waves, linkage = windows.floor.shape[1], _wave_states(windows), windows.linkage
    pushes = scores[:, :poses]
    by_pose = 0.5 * (pushes @ pushes.transpose(0, 2, 1) - informations[:, :poses, :poses])
    by_wave = 0.5 * ((scores[:, waves] ** 2).sum(axis=2) - informations[:, waves, waves])
    decay, mean_square = _wave_moments(windows, noise.wave)
    variance = variance_of(windows, noise)
    known = np.isfinite(variance)
    by_variance = np.where(known, by_variance, 0.0)
    by_factor = 2.0 * np.where(known, variance, 0.0) * by_variance
    is_heading = np.arange(by_factor.shape[1] - linkage) % 3 == 2
    slope = np.zeros(len(LOG_LEVEL_SIGMA))
    slope[0] = 2.0 * noise.roughness**2 * float(np.vdot(by_pose, windows.floor))
    slope[1] = 2.0 * noise.waviness**2 * float((by_wave * mean_square * (1.0 - decay**2)).sum())
    slope[3] = 2.0 * noise.creep**2 * float(np.vdot(by_pose, windows.creep))
    for row, level in enumerate((noise.joint_a, noise.joint_b, noise.link)[:linkage]):
        slope[4 + row] = 2.0 * level**2 * float(by_variance[:, row].sum())
    slope[7] = float(by_factor[:, linkage:][:, ~is_heading].sum())
    slope[8] = float(by_factor[:, linkage:][:, is_heading].sum())
    slope[9] = 2.0 * noise.sway**2 * float(np.vdot(by_pose, windows.sway))
    return slope


def nominal_levels(windows: Sequence[Windows]) -> NoiseLevels:
    """Return the levels of a nominal robot with the encoder resolution of this one.

    Beyond rounding, a linkage reading is assumed to have noise of 0.3 counts, of 20 urad or 10 um at least.
    """
    resolution = windows[0].signals.resolution
    if len(resolution) == 0:
        return NoiseLevels()
    joint_a, joint_b, link = (0.3 * resolution).tolist()
    return replace(
        NoiseLevels(), joint_a=max(joint_a, 2e-5), joint_b=max(joint_b, 2e-5), link=max(link, 1e-5)
    )


def is_at_limit(levels: NoiseLevels, nominal: NoiseLevels, name: str) -> bool:
    """Say whether a level is the largest that the search allows, to a hundredth."""
    above = math.log(getattr(levels, name) / getattr(nominal, name))
    return above > MAX_ABOVE - 0.01


def _identifiable(windows: Sequence[Windows]) -> NDArray[np.bool_]:
    """Say which levels (10,) recordings can identify, in the order of `NoiseLevels`."""
    linkage = windows[0].linkage > 0
    poses = any(model.signals.poses is not None for model in windows)
    both = linkage or poses
    return np.array([True, both, False, both, linkage, linkage, linkage, poses, poses, both])
