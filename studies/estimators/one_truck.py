"""How well a robot with a single truck is tracked between absolute poses: OptiOdom's differential robot.

Every PERIOD seconds one measured pose is a fix; all poses judge. A share WILD of the fixes is moved by half a
metre. The table has the root mean square of the position error over all runs of a set [mm], and NEES of the
filter: mean squared error in standard deviations over x, y and heading. Without fixes all start at the first
pose.

Peers: plain odometry that starts again at each fix; the same with the parameters that least squares find in
the fixes of the whole run; a textbook Kalman filter of the pose alone, with the parameters of the file.

Usage: python -m studies.estimators.one_truck [--period S] [--wild SHARE] [--every N] [FOLDER]
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.ipec.filter.fixes import samples_at
from omnimate.ipec.one_truck import estimate_one_truck
from omnimate.ipec.tracker import fixes_of, start_by_fixes
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS, path_covariance
from omnimate.vehicle.odometry import dead_reckon, truck_travel
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import Array, between, compose, lever_matrix, rotation, wrap
from studies.benchmark import options
from studies.datasets.optiodom.drives import each_recording

OPTIODOM = "../shared/data/real/optiodom"
JUMP = 0.5  # [m] of a wild fix
METHODS = ("odometry", "least squares", "Kalman", "filter", "without")


def thinned(recording: Recording, period: float, wild: float, chance: np.random.Generator) -> Poses:
    """Return one pose in each period [s], of which a share `wild` is moved by `JUMP`, but never the first."""
    fixes = fixes_of(recording)
    numbers = np.floor((fixes.time - fixes.time[0]) / period)
    chosen = np.flatnonzero(np.diff(numbers, prepend=-1.0))
    thin = fixes.select(chosen)
    pose = thin.pose.copy()
    moved = chance.random(len(pose)) < wild
    moved[0] = False
    angle = chance.uniform(0.0, 2.0 * math.pi, len(pose))
    pose[moved, :2] += JUMP * np.column_stack([np.cos(angle), np.sin(angle)])[moved]
    return replace(thin, pose=pose)


def restarted(recording: Recording, fixes: Poses) -> Array:
    """Return the poses `(N, 3)` of odometry that starts again at each fix."""
    path, places = dead_reckon(recording), samples_at(recording, fixes.time)
    last = np.maximum(np.searchsorted(places, np.arange(len(path)), side="right") - 1, 0)
    return np.asarray(compose(fixes.pose[last], between(path[places[last]], path)), np.float64)


def textbook(recording: Recording, fixes: Poses) -> Array:
    """Return the poses `(N, 3)` by a Kalman filter of the pose alone (Thrun et al., 2005, chapter 7)."""
    path, places = dead_reckon(recording), samples_at(recording, fixes.time)
    left, right, _ = truck_travel(recording, "a")
    wheelbase = recording.vehicle.trucks["a"].wheelbase
    pose, sigma = start_by_fixes(recording, fixes)
    covariance, out, at = np.diag(sigma**2), path.copy(), 0
    for place, measured, noise in zip(places.tolist(), fixes.pose, fixes.sigma, strict=True):
        out[at:place] = compose(pose, between(path[at], path[at:place]))
        if place > at:
            scatter = path_covariance(
                np.diff(left[at : place + 1]), np.diff(right[at : place + 1]), wheelbase
            )
            turn, before = rotation(pose[2]), pose
            pose = compose(pose, between(path[at], path[place]))
            carry = lever_matrix(pose[:2] - before[:2])
            process = CONCRETE_ROUGHNESS**2 * turn.T @ scatter @ turn
            covariance = carry @ covariance @ carry.T + process
        gain = covariance @ np.linalg.inv(covariance + np.diag(noise**2))
        innovation = measured - pose
        innovation[2] = wrap(innovation[2])
        pose, covariance, at = pose + gain @ innovation, covariance - gain @ covariance, place
    out[at:] = compose(pose, between(path[at], path[at:]))
    return out


def fitted(recording: Recording, fixes: Poses) -> Recording:
    """Return the recording with the parameters that least squares find; as it was for too few fixes."""
    try:
        truck = calibrate_truck([replace(recording, poses=fixes)], spacing=0.0).truck
    except CalibrationError:
        return recording
    return replace(recording, vehicle=recording.vehicle.with_truck("a", truck))


def measure(recording: Recording, fixes: Poses) -> dict[str, tuple[Array, float]]:
    """Return the error of the position at every pose [m], and NEES where known, of each of `METHODS`."""
    judge = fixes_of(recording)
    places = samples_at(recording, judge.time)
    start, sigma = start_by_fixes(recording, fixes)
    filtered = estimate_one_truck(recording, start, sigma, fixes=fixes)
    alone = estimate_one_truck(recording, start, fixes.sigma[0])
    tracks: dict[str, tuple[Array, Array | None]] = {
        "odometry": (restarted(recording, fixes), None),
        "least squares": (restarted(fitted(recording, fixes), fixes), None),
        "Kalman": (textbook(recording, fixes), None),
        "filter": filtered,
        "without": alone,
    }
    results = {}
    for name, (poses, sigmas) in tracks.items():
        error = poses[places] - judge.pose
        error[:, 2] = wrap(error[:, 2])
        nees = math.nan
        if sigmas is not None:
            spread = sigmas[places] ** 2 + judge.sigma**2
            nees = float(np.mean(np.sum(error**2 / spread, axis=1)))
        results[name] = np.hypot(error[:, 0], error[:, 1]), nees
    return results


def main() -> None:
    given = options(__doc__, {"folder": OPTIODOM}, period=10.0, wild=0.0, every=1)
    errors: dict[str, dict[str, list[tuple[Array, float]]]] = defaultdict(lambda: defaultdict(list))
    chance = np.random.default_rng(0)
    for number, (name, recording) in enumerate(each_recording(given.folder)):
        if number % given.every:
            continue
        fixes = thinned(recording, given.period, given.wild, chance)
        for method, result in measure(recording, fixes).items():
            errors[name.rpartition("/")[0]][method].append(result)
    print(f"{'set':<38}{'runs':>5}" + "".join(f"{method:>20}" for method in METHODS))
    ratios = []
    for name, results in errors.items():
        rms = {
            method: math.sqrt(np.mean(np.concatenate([error for error, _ in runs]) ** 2))
            for method, runs in results.items()
        }
        nees = {method: np.mean([value for _, value in runs]) for method, runs in results.items()}
        words = [
            f"{1e3 * rms[method]:20.1f}"
            if math.isnan(nees[method])
            else f"{1e3 * rms[method]:11.1f} ({nees[method]:6.2f})"
            for method in METHODS
        ]
        print(f"{name:<38}{len(results['filter']):5d}" + "".join(words), flush=True)
        ratios.append([rms[method] / rms["filter"] for method in METHODS])
    mean = np.exp(np.log(np.array(ratios)).mean(axis=0))
    print(f"{'over the filter, geometric mean':<43}" + "".join(f"{value:20.2f}" for value in mean))


if __name__ == "__main__":
    main()
