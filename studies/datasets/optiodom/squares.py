"""The OptiOdom sets that are squares of the differential robot, as runs of UMBmark."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.umbmark.experiment import Experiment, experiment_of_runs
from omnimate.calib.umbmark.runs import SquareDirection, SquareRun
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import between
from studies.datasets.optiodom.drives import read_set
from studies.datasets.optiodom.files import OptiOdomError, read_metadata, read_numbers


@dataclass(frozen=True, slots=True)
class SquareSet:
    """One set of square runs."""

    truck: Truck  # the nominal parameters of the robot
    side: float  # length of each side of the square [m]
    runs: tuple[SquareRun, ...]  # the runs in the order of their numbers


def experiment_of_optiodom(folder: Path | str, side: float | None = None) -> Experiment:
    """Return the experiment of an OptiOdom folder; `side` [m] stands in for that of its metadata.

    Raises:
        OptiOdomError: The folder is not a set of squares of the differential robot.
        DirectionError: A direction is missing, or a run is not one square.
    """
    data = read_squares(folder)
    return experiment_of_runs(str(folder), data.truck, data.side if side is None else side, data.runs)


def read_squares(folder: Path | str) -> SquareSet:
    """Return the square runs of an OptiOdom folder of the differential robot.

    The direction of each run follows from its wheels and not from the order of the set.

    Raises:
        OptiOdomError: The folder is not a set of squares, or a file in it is damaged.
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
