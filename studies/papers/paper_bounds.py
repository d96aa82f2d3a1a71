"""Whether the papers' figures that ours do not keep can be kept: the posterior Cramer-Rao bound of each.

Peers: the papers' printed figures, and IPEC as `python -m studies reproduce` measures it on the same drives.

A run of C 6.2 and a lap of O 3 are simulated with the papers' stated encoders, a concrete floor, and what a
calibration leaves. The bound is the posterior covariance of an estimator that knows the statistics of all
these (linearised; Tichavsky, Muravchik & Nehorai, 1998), here the filter without anything to learn. To an
error of that size the measurement is added: fixes before and after the run by the stated sonar calibrator.
Of each figure the median over many experiments stands here, and 5 to 95 %: a bound above the printed figure
says that no estimator from these encoders keeps it in most experiments.

The tricycle of OptiOdom is real. Nothing but its two encoders is read, so dead reckoning is all that an
estimator can do, and the bound is its error: what the calibration by the squares leaves (Cramer-Rao bound),
and the scatter of the way and of the heading that the squares show, along the measured drives on `circular`.

Usage: python -m studies.papers.paper_bounds [robots]
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.least_squares import PathCalibration
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import FilterNoise, Prior
from omnimate.vehicle.arcs import integrate
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import Array, compose
from studies.benchmark import options
from studies.datasets.optiodom.drives import find_sets, read_set
from studies.datasets.optiodom.scores import calibrate_squares, score
from studies.papers.linkage_numbers import lap_errors
from studies.papers.protocols import CLAPPER_SONAR, OMNIMATE_SONAR, Estimator, path_of, sizes
from studies.papers.robots import LEFT_BEHIND, UNCALIBRATED, laps, rectangle

EXPERIMENTS = 4000
KNOWN = FilterNoise(sideways=0.0, trust=1e9)  # the simulated floor, which needs no learning
TRICYCLE = "../shared/data/real/optiodom/tricyc"
CIRCLES = 300  # experiments on the tricycle's drives
SURE = 1e-9  # probability that anything is wrong beside what the prior's deviations say


def bound(recording: Recording, prior: Prior) -> Array:
    """Return the standard deviations `(3,)` of the second lap's return error [m, m, rad].

    The estimator is given the exact poses before and after the first lap, more than a robot has.
    """
    assert recording.poses is not None
    fixes = recording.poses.of("a")
    exact = Poses(fixes.time[:2], fixes.body[:2], fixes.pose[:2], np.zeros((2, 3)))
    known = estimate(recording, fixes.pose[0], fixes=exact, noise=KNOWN, prior=replace(prior, wrong=SURE))
    return np.asarray(known.sigma_a[_end(recording)])


def drawn(sigmas: Sequence[Array], sonar: Array, runs: int, chance: np.random.Generator) -> Array:
    """Return return errors `(EXPERIMENTS, runs, 3)` of these deviations, measured with a sonar."""
    which = chance.integers(0, len(sigmas), (EXPERIMENTS, runs))
    errors = chance.normal(size=(EXPERIMENTS, runs, 3)) * np.array(sigmas)[which]
    for _ in range(2):  # the fixes before and after
        errors += chance.uniform(-1.0, 1.0, (EXPERIMENTS, runs, 3)) * sonar
    return np.asarray(errors)


def _end(recording: Recording) -> int:
    """Return the number of the sample at the end of the second lap."""
    assert recording.run is not None
    return int(np.searchsorted(recording.time, recording.run.laps[1].end - 1e-6))


def errors_of(recording: Recording, name: Estimator) -> Array:
    """Return true minus calculated pose `(3,)` at the end of the second lap, from its start on."""
    assert recording.poses is not None
    path = path_of(recording, name, recording.poses.of("a"), LEFT_BEHIND)
    second: Array = lap_errors(recording, path)[1]
    return second


def away(
    drive: Drive, calibration: PathCalibration, off: Array, level: float, chance: np.random.Generator
) -> Array:
    """Return how far dead reckoning is away [m] at each reading of a drive, in one experiment, shape `(N,)`.

    The true coordinates differ by `off` `(P,)` from those of the calibration, and the scatter is `level`
    times what it says.
    """
    robot, fitted = calibration.kinematics, calibration.estimate
    steps = robot.steps(drive.readings, np.zeros(len(off)))
    variances = level**2 * np.array([noise.value**2 for noise in fitted.noises[: steps.noise.shape[1]]])
    values, vectors = np.linalg.eigh(np.einsum("c,ncij->nij", variances, steps.noise))
    scale = np.sqrt(np.maximum(values, 0.0)) * chance.normal(size=values.shape)
    scatter = np.einsum("nij,nj->ni", vectors, scale)
    true = integrate(compose(robot.steps(drive.readings, off).increment, scatter))
    missed = integrate(steps.increment) - true
    return np.asarray(np.hypot(missed[:, 0], missed[:, 1]))


def show_tricycle(chance: np.random.Generator) -> None:
    """Print the tricycle's error on `circular`, the mean over the sets of the rms along all runs."""
    sets = [read_set(folder) for folder in find_sets(TRICYCLE)]
    calibration = calibrate_squares(sets)
    circles = [data for data in sets if data.path == "circular"]
    ours = [score(data, calibration.kinematics, calibration.lever).rms for data in circles]
    count = len(calibration.kinematics.coordinates)
    spread = calibration.estimate.covariance[:count, :count]
    print(f"OptiOdom's tricycle on circular: ours {1e3 * np.mean(ours):.1f} mm")
    for what, left, level in (
        ("circular, as calibrated [mm]", 1.0, 1.0),
        ("circular, parameters known exactly [mm]", 0.0, 1.0),
        ("circular, nothing but the calibration [mm]", 1.0, 0.0),
    ):
        figures = np.empty(CIRCLES)
        for number in range(CIRCLES):
            off = left * chance.multivariate_normal(np.zeros(count), spread)
            runs = [
                np.concatenate([away(drive, calibration, off, level, chance) for drive in data.drives])
                for data in circles
            ]
            figures[number] = 1e3 * np.mean([np.sqrt(np.mean(run**2)) for run in runs])
        show(what, 52.0, figures)


def show(what: str, printed: float, figures: Array, *, at_least: bool = False) -> None:
    """Print a figure at the bound beside the printed one, and in how many experiments it is kept."""
    low, middle, high = np.percentile(figures, [5, 50, 95])
    kept = np.mean(figures >= printed if at_least else figures <= printed)
    print(
        f"{what:<46} printed {printed:6.2f}   at the bound {middle:6.2f} ({low:.2f} to {high:.2f})   "
        f"kept in {100.0 * kept:.0f} %"
    )


def main() -> None:
    robots = options(__doc__, {"robots": 10}).robots
    chance = np.random.default_rng(1)
    runs = [rectangle(seed, way, 2, 10) for seed in range(robots) for way in ("cw", "ccw")]
    sigmas = [bound(run, LEFT_BEHIND) for run in runs]
    plain = np.array([errors_of(run, "plain") for run in runs])
    ipec = np.array([errors_of(run, "CLAPPER") for run in runs])
    places, headings = sizes(drawn(sigmas, CLAPPER_SONAR, 20, chance))
    _deviations("C 6.2, a run with 10 bumps", sigmas, ipec)
    show("C 6.2 worst position of 20 runs [mm]", 50.0, places.max(axis=-1))
    show("C 6.2 mean |heading| of 20 runs [degrees]", 0.3, headings.mean(axis=-1))
    gain = sizes(plain)[1].mean() / headings.mean(axis=-1)
    show("C 6.2 mean |heading| without / with IPEC", 20.0, gain, at_least=True)
    recordings = [laps(seed, way) for seed in range(robots) for way in ("cw", "ccw")]
    sigmas = [bound(recording, UNCALIBRATED) for recording in recordings]
    ipec = np.array([errors_of(recording, "OmniMate") for recording in recordings])
    _deviations("O 3, a lap without bumps", sigmas, ipec)
    headings = sizes(drawn(sigmas, OMNIMATE_SONAR, 10, chance))[1]
    show("O 3 worst heading of 10 laps [degrees]", 0.4, headings.max(axis=-1))
    show_tricycle(chance)


def _deviations(what: str, sigmas: Sequence[Array], errors: Array) -> None:
    place, heading = np.sqrt(np.mean(np.square(sigmas), axis=0).dot([[1, 0], [1, 0], [0, 1]]))
    ours = math.sqrt(np.mean(errors[:, 0] ** 2 + errors[:, 1] ** 2)), math.sqrt(np.mean(errors[:, 2] ** 2))
    print(
        f"{what}: rms at the bound {1e3 * place:.1f} mm, {math.degrees(heading):.3f} degrees; "
        f"IPEC {1e3 * ours[0]:.1f} mm, {math.degrees(ours[1]):.3f} degrees"
    )


if __name__ == "__main__":
    main()
