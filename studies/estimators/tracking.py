"""The error of the estimator along drives of several worlds, by case, and whether it knows its error.

Peers: plain odometry, IPEC and OmniMate's form over the same drives.

The estimator is given counts alone, with both of its priors; true or measured poses of truck a judge. A
case is reached where the rms error is at most 1.1 times the smallest of the peers', or below 5 mm. NEES is
the mean squared error in standard deviations, summed over x, y and heading.

Usage: python -m studies.estimators.tracking [--seed N] [FOLDER [WORLD ...]]

FOLDER keeps the drives (`build/tracking` by default). A WORLD is made, engine, mujoco, bullet,
wide, or a folder of recordings with labels.json. Without one: the first two, and the recordings beside the
checkout. Another seed draws other robots, floors and drives: the constants were chosen with seed 4 in view.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.ipec.corrector import Method, correct
from omnimate.ipec.errors import LinkageChannelError
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array, between, wrap
from studies.estimators.tracking_worlds import SEED, drives_of

DATA = Path("../shared/data")
RECORDED = tuple(str(DATA / name) for name in ("contact", "concealed", "concealed2"))
METHODS: dict[str, Method] = {"plain": "plain", "IPEC": "clapper", "OmniMate": "omnimate"}
PRIORS = {"calibrated": CALIBRATED, "nominal": NOMINAL}
FACTOR, SMALL = 1.1, 0.005  # times the best peer; [m] below which an error always counts as reached
LIMITS = 0.216, 9.348  # of NEES: 95 % of a chi-squared variable with 3 degrees of freedom
FLOOR = np.array([1e-3, 1e-3, 1e-3])  # [m, m, rad] below which no error counts: a good tracker's scatter
STILL = 2e-3  # [m] of the way within which the poses before a drive are averaged


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured of one case."""

    what: str  # name of the case
    errors: dict[str, float]  # root mean square of the distance along the drive by each method and prior [m]
    nees: dict[str, float]  # NEES by each prior

    @property
    def best(self) -> float:
        """The smallest error of the peers [m]."""
        return min(self.errors[name] for name in METHODS)

    def is_reached(self, prior: str) -> bool:
        """Whether the estimator is as good as is wanted."""
        return self.errors[prior] <= max(FACTOR * self.best, SMALL)


@dataclass(frozen=True, slots=True)
class Judge:
    """Poses of truck a from outside, from the pose at the start on."""

    time: Array  # time of each pose [s], shape `(K,)`
    pose: Array  # poses in the frame of the first [m, m, rad], shape `(K, 3)`
    sigma: Array  # their standard deviations, those of the first pose included, shape `(K, 3)`


def judge_of(recording: Recording) -> Judge:
    """Return what judges a recording; the poses before it moves are averaged."""
    assert recording.poses is not None
    poses = recording.poses.of("a")
    poses = poses.select(np.isfinite(poses.pose).all(axis=1))
    time, pose, sigma = poses.time, poses.pose, poses.sigma
    wheels = [recording.wheel_angle(wheel) for wheel in ("a.left", "a.right")]
    rolled = (
        sum(np.abs(angle - angle[0]) for angle in wheels) * recording.vehicle.trucks["a"].wheel_diameter_left
    )
    still = max(1, int(np.searchsorted(time, recording.time[np.argmax(rolled > 4.0 * STILL)])))
    first = np.array([*pose[:still, :2].mean(axis=0), pose[0, 2] + wrap(pose[:still, 2] - pose[0, 2]).mean()])
    own = sigma[0] / np.sqrt(still)
    away = pose - first
    spread = np.hypot(sigma, own)
    spread[:, :2] = np.hypot(spread[:, :2], (own[2] * np.hypot(away[:, 0], away[:, 1]))[:, None])
    return Judge(time, between(first, pose), spread)


def errors_of(judge: Judge, time: Array, path: Array) -> Array:
    """Return judge minus estimate [m, m, rad] at each of the judge's poses, shape `(K, 3)`."""
    from_start = between(path[0], path)
    heading = np.unwrap(from_start[:, 2])
    seen = np.stack(
        [np.interp(judge.time, time, column) for column in (*from_start[:, :2].T, heading)], axis=1
    )
    error = judge.pose - seen
    return np.stack([error[:, 0], error[:, 1], wrap(error[:, 2])], axis=1)


def rms(error: Array) -> float:
    """Return the root mean square of the distance along the drive [m]."""
    return float(np.sqrt(np.mean(error[:, 0] ** 2 + error[:, 1] ** 2)))


def nees(judge: Judge, error: Array, time: Array, sigma: Array) -> float:
    """Return the mean squared error in standard deviations, summed over x, y and heading: 3 if consistent.

    The first second of the judge's poses does not count.
    """
    known = np.stack([np.interp(judge.time, time, column) for column in sigma.T], axis=1)
    squared = np.sum(error**2 / (known**2 + judge.sigma**2 + FLOOR**2), axis=1)
    return float(np.mean(squared[judge.time > judge.time[0] + 1.0]))


def measure(what: str, recording: Recording) -> Row:
    """Return what was measured of one case; LinkageChannelError where a channel is unreadable."""
    judge = judge_of(recording)
    errors = {
        name: rms(errors_of(judge, recording.time, correct(recording, method=method).pose_a))
        for name, method in METHODS.items()
    }
    means: dict[str, float] = {}
    for name, prior in PRIORS.items():
        result = estimate(recording, prior=prior)
        error = errors_of(judge, recording.time, result.pose_a)
        errors[name] = rms(error)
        means[name] = nees(judge, error, recording.time, result.sigma_a)
    return Row(what, errors, means)


def show(row: Row) -> None:
    """Print a case; a star marks an error that is larger than wanted."""
    cells = [f"{1e3 * row.errors[name]:9.1f}" for name in METHODS]
    for prior in PRIORS:
        mark = " " if row.is_reached(prior) else "*"
        cells.append(f"{1e3 * row.errors[prior]:11.1f}{mark} {row.nees[prior]:8.1f}")
    print(f"{row.what[:44]:<44}{''.join(cells)}", flush=True)


def summarise(rows: list[Row]) -> bool:
    """Print how many cases of a world are reached; return whether all are, and NEES in 9 of 10."""
    good = True
    for prior in PRIORS:
        reached = sum(row.is_reached(prior) for row in rows)
        below = sum(row.nees[prior] <= LIMITS[1] for row in rows)
        within = sum(LIMITS[0] <= row.nees[prior] <= LIMITS[1] for row in rows)
        ratio = float(np.median([row.errors[prior] / max(row.best, 1e-4) for row in rows]))
        print(
            f"  {prior}: {reached} of {len(rows)} reached, median {ratio:.2f} times the best peer; "
            f"NEES below {LIMITS[1]} in {below}, above {LIMITS[0]} as well in {within}"
        )
        good = good and reached == len(rows) and below >= 0.9 * len(rows)
    return good


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("build/tracking"))
    parser.add_argument("worlds", nargs="*")
    asked = parser.parse_args()
    folder = asked.folder
    worlds = asked.worlds or ["made", "engine", *(world for world in RECORDED if Path(world).exists())]
    good = True
    for world in worlds:
        print(f"\n{world}: rms position error along the drive [mm], and NEES")
        names = "".join(f"{name:>9}" for name in METHODS) + "".join(f"{name:>12}     NEES" for name in PRIORS)
        print(f"{'':<44}{names}")
        rows = []
        for what, recording in drives_of(world, folder, asked.seed):
            try:
                rows.append(measure(what, recording))
            except LinkageChannelError as error:
                print(f"{what[:44]:<44} is refused: {str(error)[:80]}")
                continue
            show(rows[-1])
        good = summarise(rows) and good
    sys.exit(not good)


if __name__ == "__main__":
    main()
