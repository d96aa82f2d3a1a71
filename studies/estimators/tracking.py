"""The error of the estimator along drives of several worlds, by case, and whether it knows its error.

Peers: plain odometry, IPEC and OmniMate's form over the same drives.

The estimator is given counts alone, with both of its priors; true or measured poses of truck a judge. A
case is reached where the rms error is at most 1.1 times the smallest of the peers', or below 5 mm. NEES is
the mean squared error in standard deviations, summed over x, y and heading.

Usage: python -m studies.estimators.tracking [--seed N] [FOLDER [WORLD ...]]

FOLDER keeps drives and pictures (`build/tracking` by default). A WORLD is made, engine, mujoco, bullet,
wide, or a folder of recordings with labels.json. Without one: the first two, and the recordings beside the
checkout. Another seed draws other robots, floors and drives: the constants were chosen with seed 4 in view.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import correct
from omnimate.ipec.errors import LinkageChannelError
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL, SIZES
from studies.estimators.tracking_pictures import draw_errors, draw_nees, draw_states
from studies.estimators.tracking_scores import errors_of, judge_of, nees, rms, squared
from studies.estimators.tracking_worlds import SEED, drives_of

if TYPE_CHECKING:
    from omnimate.ipec.corrector import Method
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

DATA = Path("../shared/data")
RECORDED = tuple(str(DATA / name) for name in ("contact", "concealed", "concealed2"))
METHODS: dict[str, Method] = {"plain": "plain", "IPEC": "clapper", "OmniMate": "omnimate"}
PRIORS = {"calibrated": CALIBRATED, "nominal": NOMINAL}
FACTOR, SMALL = 1.1, 0.005  # times the best peer; [m] below which an error always counts as reached
LIMITS = 0.216, 9.348  # of NEES: 95 % of a chi-squared variable with 3 degrees of freedom


@dataclass(frozen=True, slots=True)
class Row:
    """What was measured of one case.

    Attributes:
        what: Name of the case.
        errors: Root mean square of the distance along the drive by each method and prior [m].
        nees: NEES by each prior.
        standing: NEES of the first prior at each of the judge's poses, shape `(K,)`.
        slow: What the encoders err by at the end, with the first prior, shape `(11,)`, in sizes of a suspect.
        sigma: Standard deviations of these, shape `(11,)`.
        curves: Error of each method at each of the judge's poses [m, m, rad], `(K, 3)`.
        time: Time of these poses [s], shape `(K,)`.
    """

    what: str
    errors: dict[str, float]
    nees: dict[str, float]
    standing: Array
    slow: Array
    sigma: Array
    curves: dict[str, Array]
    time: Array

    @property
    def best(self) -> float:
        """The smallest error of the peers [m]."""
        return min(self.errors[name] for name in METHODS)

    def is_reached(self, prior: str) -> bool:
        """Whether the estimator is as good as is wanted."""
        return self.errors[prior] <= max(FACTOR * self.best, SMALL)


def measure(what: str, recording: Recording) -> Row:
    """Return what was measured of one case.

    Raises:
        LinkageChannelError: A channel of the linkage cannot be read.
    """
    judge = judge_of(recording)
    curves = {
        name: errors_of(judge, recording.time, correct(recording, method=method).pose_a)
        for name, method in METHODS.items()
    }
    means: dict[str, float] = {}
    results = {name: estimate(recording, prior=prior) for name, prior in PRIORS.items()}
    for name, result in results.items():
        curves[name] = errors_of(judge, recording.time, result.pose_a)
        means[name] = nees(judge, curves[name], recording.time, result.sigma_a)
    errors = {name: rms(error) for name, error in curves.items()}
    first, scale = results["calibrated"], np.array((*SIZES[:4], *SIZES[6:13]))
    standing = squared(judge, curves["calibrated"], recording.time, first.sigma_a)
    learned = first.slow.vector / scale
    time = judge.time - judge.time[0]
    return Row(what, errors, means, standing, learned, first.slow.sigma / scale, curves, time)


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
    """Print the table of each world, and draw its pictures."""
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
        name = f"{Path(world).name}-{asked.seed}"
        draw_errors(rows, folder / f"{name}-errors.png")
        draw_nees(rows, folder / f"{name}-nees.png", LIMITS)
        draw_states(rows, folder / f"{name}-states.png")
        print(f"  drawn: {folder / name}-errors.png, -nees.png and -states.png")
    sys.exit(not good)


if __name__ == "__main__":
    main()
