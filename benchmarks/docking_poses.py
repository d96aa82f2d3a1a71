"""How well poses at docks alone calibrate a real robot: the first and the last pose of each OptiOdom drive.

The circular and ivanjko sets are used, the free drives are held out and judge alone. What could be reached:
the error that the fit's Cramer-Rao bound lets expect on the free drives, and the least that any parameters
leave there. What keeps from it: the parameters that each set shows by itself.

Peers, in the same run: all poses, and the nominal robot.

Usage: python -m benchmarks.docking_poses [ROOT]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from omnimate.calib.paths.least_squares import SPACING, calibrate_path
from omnimate.calib.paths.reference import dead_reckoned
from omnimate.importers.optiodom.drives import read_set
from omnimate.importers.optiodom.files import find_sets
from omnimate.importers.optiodom.scores import score

if TYPE_CHECKING:
    from omnimate.calib.paths.drives import Drive
    from omnimate.calib.paths.kinematics import Kinematics
    from omnimate.calib.paths.least_squares import PathCalibration
    from omnimate.importers.optiodom.drives import DriveSet
    from omnimate.vehicle.se2 import Array

ROOT = "../shared/data/real/optiodom/diff"
WANTED = 0.020  # [m] rms on the free drives
USED = {"circular", "ivanjko"}
_STEP = 1e-5  # of a coordinate, for numerical derivatives


def docked(drive: Drive) -> Drive:
    """Return a drive of whose poses the first and the last one are known."""
    ends = [0, -1]
    return replace(drive, fix_time=drive.fix_time[ends], pose=drive.pose[ends], sigma=drive.sigma[ends])


def away(data: DriveSet, kinematics: Kinematics, coordinates: Array) -> Array:
    """Return how far dead reckoning with corrected kinematics is from all poses of a set [m], `(2 N,)`."""
    corrected = kinematics.corrected(coordinates)
    return np.concatenate(
        [(dead_reckoned(drive, corrected) - drive.pose)[:, :2].ravel() for drive in data.drives]
    )


def expected(data: DriveSet, kinematics: Kinematics, calibration: PathCalibration) -> float:
    """Return the rms error [m] on a set that the bound of a calibration's parameters lets expect."""
    place = calibration.estimate.coordinates
    slopes = [
        (away(data, kinematics, place + step) - away(data, kinematics, place - step)) / (2.0 * _STEP)
        for step in _STEP * np.eye(len(place))
    ]
    slope = np.stack(slopes, axis=-1)
    variance = np.einsum("ni,ij,nj->n", slope, calibration.estimate.covariance, slope)
    return float(np.sqrt(2.0 * variance.mean()))


def fitted_to(data: DriveSet, kinematics: Kinematics) -> Kinematics:
    """Return the kinematics that come closest to all poses of a set."""
    start = np.zeros(len(kinematics.coordinates))
    return kinematics.corrected(least_squares(lambda place: away(data, kinematics, place), start).x)


def words_of(kinematics: Kinematics) -> str:
    """Return wheelbase and ratio of the wheels in words."""
    value = kinematics.values(np.zeros(len(kinematics.coordinates)))
    ratio = value["right wheel diameter"] / value["left wheel diameter"]
    return (
        f"wheelbase {1e3 * value['wheelbase']:.2f} mm, right over left wheel 1 {1e3 * (ratio - 1.0):+.2f}e-3"
    )


def main() -> int:
    sets = [read_set(folder) for folder in find_sets(sys.argv[1] if len(sys.argv) > 1 else ROOT)]
    used = [data for data in sets if data.path in USED]
    free = [data for data in sets if data.path == "free"]
    nominal = used[0].kinematics
    drives = [drive for data in used for drive in data.drives]
    worst = 0.0
    for words, chosen, spacing in (
        ("docks alone", [docked(drive) for drive in drives], 0.0),
        ("all poses", drives, SPACING),
    ):
        calibration = calibrate_path(chosen, nominal, spacing=spacing)
        print(f"{words}: {len(drives)} drives; {words_of(calibration.kinematics)}")
        for data in free:
            raw, fitted = score(data, data.kinematics), score(data, calibration.kinematics)
            bound = expected(data, nominal, calibration)
            print(
                f"  {data.name} {1e3 * raw.rms:.1f} -> {1e3 * fitted.rms:.1f} mm rms; "
                f"by the bound of the parameters {1e3 * bound:.1f}"
            )
            if words == "docks alone":
                worst = max(worst, fitted.rms)
    for data in free:
        own = fitted_to(data, nominal)
        print(f"{data.name} itself: {words_of(own)}; {1e3 * score(data, own).rms:.1f} mm rms")
    print("docks of single sets alone, and their error on the free drives:")
    for data in sets:
        if data.path != "free":
            single = calibrate_path([docked(drive) for drive in data.drives], nominal, spacing=0.0).kinematics
            errors = ", ".join(f"{1e3 * score(other, single).rms:.1f}" for other in free)
            print(f"  {data.name}: {words_of(single)}; {errors} mm rms")
    print(f"wanted with docks alone: at most {1e3 * WANTED:.0f} mm rms")
    return 0 if worst <= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
