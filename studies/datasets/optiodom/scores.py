"""The real robots of the OptiOdom data: calibrated on the squares, scored on every set.

The calibration uses the squares alone; `circular`, `free` and `ivanjko` are held out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential, Kinematics
from omnimate.calib.paths.least_squares import PathCalibration, calibrate_path
from omnimate.calib.paths.reference import dead_reckoned
from omnimate.calib.umbmark.experiment import Experiment, experiment_of_runs
from omnimate.calib.umbmark.printed import solve_printed
from omnimate.calib.umbmark.runs import SquareDirection, SquareRun, return_errors
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import Array, between
from studies.datasets.optiodom.drives import (
    DriveSet,
    OptiOdomError,
    find_sets,
    read_metadata,
    read_numbers,
    read_set,
)


class SquareSet(NamedTuple):
    """The runs of squares of a nominal robot, in the order of their numbers."""

    truck: Truck
    side: float  # of the square [m]
    runs: tuple[SquareRun, ...]


def experiment_of_optiodom(folder: Path | str, side: float | None = None) -> Experiment:
    """Return the experiment of an OptiOdom folder; `side` [m] stands in for that of its metadata.

    DirectionError where a direction is missing or a run is not one square; OptiOdomError as `read_squares`.
    """
    truck, stated, runs = read_squares(folder)
    return experiment_of_runs(str(folder), truck, stated if side is None else side, runs)


def read_squares(folder: Path | str) -> SquareSet:
    """Return the square runs of an OptiOdom folder of the differential robot.

    The direction of each run follows from its wheels and not from the order of the set. OptiOdomError where
    the folder is no such set, or a file in it is damaged.
    """
    folder = Path(folder)
    metadata = read_metadata(folder)
    kind = metadata.get("type", [""])[0]
    if kind != "diff":
        raise OptiOdomError(folder, f"robot type {kind!r}; UMBmark needs the differential robot, diff")
    side = read_numbers(folder, metadata, "L", 1)[0]
    count, data = int(read_numbers(folder, metadata, "N", 1)[0]), read_set(folder)
    if len(data.drives) != count:
        raise OptiOdomError(folder, f"{len(data.drives)} runs; expected N = {count} as the metadata says")
    assert isinstance(data.kinematics, Differential)  # by its type
    return SquareSet(data.kinematics.truck, side, tuple(map(_run, data.drives)))


def _run(drive: Drive) -> SquareRun:
    poses = drive.pose.copy()
    poses[:, 2] = np.unwrap(poses[:, 2])
    wheel_angles = np.diff(drive.readings, axis=0, prepend=0.0)
    left, right = drive.readings[-1]
    direction: SquareDirection = "cw" if right < left else "ccw"
    return SquareRun(direction, between(poses[0], poses[-1]), wheel_angles, drive.source)


@dataclass(frozen=True, slots=True)
class Score:
    """Distance between dead reckoning and the measured poses, over the runs of one set."""

    final: float  # distance at the end of a run, root mean square over the runs [m]
    rms: float  # distance along the path, root mean square over all samples of all runs [m]


@dataclass(frozen=True, slots=True)
class SetScores:
    name: str  # name of the set: robot/path/date
    runs: int  # number of runs
    seen: bool  # whether the calibration used the set
    raw: Score  # score with the nominal parameters of the set
    printed: Score | None  # score with the parameters by the printed UMBmark equations; None for the tricycle
    fitted: Score  # score with the parameters by the least-squares fit
    # score with the parameters by the least-squares fit, and with the markers at the pose on the robot that
    # was estimated from the squares
    placed: Score


@dataclass(frozen=True, slots=True)
class RobotScores:
    kind: str  # kind of robot: diff or tricyc
    calibration: PathCalibration  # calibration by least squares on all squares
    # model calibrated by the printed UMBmark equations, x and y averaged, on all squares; None for the
    # tricycle
    printed: Kinematics | None
    sets: tuple[SetScores, ...]  # scores of each set, in order


def score_optiodom(root: Path | str) -> tuple[RobotScores, ...]:
    """Return the scores of every robot under a root that has squares; OptiOdomError where none has."""
    folders = find_sets(root)
    robots: dict[str, list[tuple[Path, DriveSet]]] = {}
    for folder in folders:
        data = read_set(folder)
        robots.setdefault(data.robot, []).append((folder, data))
    scored = [
        _score_robot(kind, sets)
        for kind, sets in robots.items()
        if any(data.path == "square" for _, data in sets)
    ]
    if not scored:
        raise OptiOdomError(root, "no folder square/ under it; the calibration needs squares")
    return tuple(scored)


def calibrate_squares(sets: Sequence[DriveSet]) -> PathCalibration:
    """Return the least-squares calibration on the squares among sets of one robot.

    The pose of the markers on the robot is estimated too, because they are mounted by eye.
    """
    drives = [drive for data in sets if data.path == "square" for drive in data.drives]
    nominal = next(data.kinematics for data in sets if data.path == "square")
    return calibrate_path(drives, nominal, with_offset=True)


def score(data: DriveSet, kinematics: Kinematics, lever: Array | None = None) -> Score:
    """Return the score of a model's dead reckoning on a set; `lever` `(3,)` places the markers."""
    distances = [_distances(drive, kinematics, lever) for drive in data.drives]
    finals = np.array([run[-1] for run in distances])
    every = np.concatenate(distances)
    return Score(float(np.sqrt(np.mean(finals**2))), float(np.sqrt(np.mean(every**2))))


def _distances(drive: Drive, kinematics: Kinematics, lever: Array | None) -> Array:
    away = dead_reckoned(drive, kinematics, lever) - drive.pose
    return np.asarray(np.hypot(away[:, 0], away[:, 1]), np.float64)


def _score_robot(kind: str, sets: list[tuple[Path, DriveSet]]) -> RobotScores:
    calibration = calibrate_squares([data for _, data in sets])
    printed = _printed(sets) if kind == "diff" else None
    return RobotScores(
        kind,
        calibration,
        printed,
        tuple(
            SetScores(
                data.name,
                len(data.drives),
                data.path == "square",
                score(data, data.kinematics),
                None if printed is None else score(data, printed),
                score(data, calibration.kinematics),
                score(data, calibration.kinematics, calibration.lever),
            )
            for _, data in sets
        ),
    )


def _printed(sets: list[tuple[Path, DriveSet]]) -> Kinematics:
    """Return the model calibrated by the printed equations, U (4.17)-(4.32), from the runs of all squares."""
    squares = [read_squares(folder) for folder, data in sets if data.path == "square"]
    truck, side, _ = squares[0]
    runs = [run for *_, of_set in squares for run in of_set]
    errors = return_errors(runs, truck, side, str(sets[0][0].parent))
    correction = solve_printed(errors, truck.wheelbase)
    return Differential(corrected_truck(truck, correction.e_b, correction.e_d))
