"""How well poses at docks alone calibrate a real robot: the first and the last pose of each OptiOdom drive.

The circular and ivanjko sets are used, the free drives are held out and judge alone. What could be reached:
the error that the fit's Cramer-Rao bound lets expect on the free drives, and the least that any parameters
leave there. What keeps from it: the parameters that each set shows by itself, and the error that a robot
which differs so from set to set lets expect on a drive of yet another set.

Peers, in the same run: all poses, the nominal robot, and the first and the last pose of the free drive itself
with the sets as the prior, as a fleet's daily run has them. There the last pose is not held out.

Usage: python -m studies.estimators.docking_poses [ROOT]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential, Kinematics
from omnimate.calib.paths.least_squares import SPACING, PathCalibration, calibrate_path
from omnimate.calib.paths.reference import dead_reckoned
from omnimate.fleet.segments import cut_segments
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array
from studies.benchmark import options
from studies.datasets.optiodom.drives import DriveSet, each_recording, find_sets, read_set
from studies.datasets.optiodom.scores import score

ROOT = "../shared/data/real/optiodom/diff"
WANTED = 0.020  # [m] rms on the free drives
USED = {"circular", "ivanjko"}
_STEP = 1e-5  # of a coordinate, for numerical derivatives
# Left wheel, right wheel and wheelbase by wheelbase, mean diameter and ratio of the wheels, to first order.
BY_COORDINATES = np.array([[0.0, 1.0, -0.5], [0.0, 1.0, 0.5], [1.0, 0.0, 0.0]])


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


def spread_on(data: DriveSet, kinematics: Kinematics, place: Array, covariance: Array) -> float:
    """Return the rms error [m] on a set that coordinates `(P,)` of a covariance `(P, P)` let expect."""
    slopes = [
        (away(data, kinematics, place + step) - away(data, kinematics, place - step)) / (2.0 * _STEP)
        for step in _STEP * np.eye(len(place))
    ]
    slope = np.stack(slopes, axis=-1)
    variance = np.einsum("ni,ij,nj->n", slope, covariance, slope)
    return float(np.sqrt(2.0 * variance.mean()))


def spread_of(calibrations: Sequence[PathCalibration]) -> tuple[Array, Array]:
    """Return the mean of the sets' coordinates `(P,)`, and the covariance of another set around it `(P, P)`.

    It is that of the sets, each of which counts alike, and of their mean.
    """
    places = np.array([calibration.estimate.coordinates for calibration in calibrations])
    return places.mean(axis=0), np.cov(places.T) * (1.0 + 1.0 / len(places))


def with_docks(recording: Recording, mean: Kinematics, between: Array) -> Kinematics:
    """Return the robot by the first and the last pose of a drive, with the sets' covariance as the prior."""
    assert isinstance(mean, Differential)  # as all sets of this robot are
    assert recording.poses is not None
    vehicle = recording.vehicle.with_truck("a", mean.truck)
    cut = cut_segments(replace(recording, vehicle=vehicle, poses=recording.poses.select(np.array([0, -1]))))
    assert cut is not None
    way = cut[0]
    slope = way.jacobian[0] @ BY_COORDINATES
    gain = between @ slope.T
    gain = gain @ np.linalg.inv(slope @ gain + way.covariance(CONCRETE_ROUGHNESS))
    return mean.corrected(gain @ way.residual[0])


def fitted_to(data: DriveSet, kinematics: Kinematics) -> Kinematics:
    """Return the kinematics that come closest to all poses of a set."""
    optimum = least_squares(partial(away, data, kinematics), np.zeros(len(kinematics.coordinates)))
    return kinematics.corrected(optimum.x)


def words_of(kinematics: Kinematics) -> str:
    """Return wheelbase and ratio of the wheels in words."""
    value = kinematics.values(np.zeros(len(kinematics.coordinates)))
    ratio = value["right wheel diameter"] / value["left wheel diameter"]
    return (
        f"wheelbase {1e3 * value['wheelbase']:.2f} mm, right over left wheel 1 {1e3 * (ratio - 1.0):+.2f}e-3"
    )


def main() -> int:
    root = options(__doc__, {"root": ROOT}).root
    sets, recordings = [read_set(folder) for folder in find_sets(root)], dict(each_recording(root))
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
            estimate = calibration.estimate
            bound = spread_on(data, nominal, estimate.coordinates, estimate.covariance)
            print(
                f"  {data.name} {1e3 * raw.rms:.1f} -> {1e3 * fitted.rms:.1f} mm rms; "
                f"by the bound of the parameters {1e3 * bound:.1f}"
            )
            if words == "docks alone":
                worst = max(worst, fitted.rms)
    alone = {
        data.name: calibrate_path([docked(drive) for drive in data.drives], nominal, spacing=0.0)
        for data in sets
        if data.path != "free"
    }
    place, between = spread_of([alone[data.name] for data in used])
    mean = nominal.corrected(place)
    for data in free:
        after = with_docks(recordings[f"{data.name}/run-01"], mean, between)
        spread = spread_on(data, nominal, place, between)
        print(f"mean of the sets, docks alone: {words_of(mean)}")
        print(
            f"  {data.name} {1e3 * score(data, mean).rms:.1f} mm rms; by the scatter of the sets "
            f"{1e3 * spread:.1f}"
        )
        print(f"with the free drive's own docks besides, which are not held out: {words_of(after)}")
        print(f"  {data.name} {1e3 * score(data, after).rms:.1f} mm rms")
    for data in free:
        by_docks = fitted_to(data, nominal)
        print(f"{data.name} itself: {words_of(by_docks)}; {1e3 * score(data, by_docks).rms:.1f} mm rms")
    print("docks of single sets alone, and their error on the free drives:")
    for name, calibration in alone.items():
        errors = ", ".join(f"{1e3 * score(other, calibration.kinematics).rms:.1f}" for other in free)
        print(f"  {name}: {words_of(calibration.kinematics)}; {errors} mm rms")
    print(f"wanted with docks alone: at most {1e3 * WANTED:.0f} mm rms")
    return 0 if worst <= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
