"""The OptiOdom sets that are squares of the differential robot, as runs of UMBmark."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.calib.umbmark.experiment import Experiment, experiment_of_runs
from omnimate.calib.umbmark.runs import SquareDirection, SquareRun
from omnimate.files.importers.errors import OptiOdomError
from omnimate.vehicle.parameters import ParameterError, Truck
from omnimate.vehicle.se2 import between
from studies.datasets.optiodom.files import read_metadata, read_numbers, read_rows


@dataclass(frozen=True, slots=True)
class SquareSet:
    """One set of square runs.

    Attributes:
        truck: The nominal parameters of the robot.
        side: Length of each side of the square [m].
        runs: The runs in the order of their numbers.
    """

    truck: Truck
    side: float
    runs: tuple[SquareRun, ...]


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
    ticks_per_turn = (
        read_numbers(folder, metadata, "ngear", 1)[0] * read_numbers(folder, metadata, "encRes", 1)[0]
    )
    right, left = read_numbers(folder, metadata, "Di", 2)
    try:
        truck = Truck(read_numbers(folder, metadata, "Li", 1)[0], left, right)
    except ParameterError as error:
        raise OptiOdomError(folder, str(error)) from error
    count = int(read_numbers(folder, metadata, "N", 1)[0])
    files = sorted(folder.glob("*_run-[0-9][0-9].csv*"))
    if len(files) != count:
        raise OptiOdomError(folder, f"{len(files)} runs; expected N = {count} as the metadata says")
    return SquareSet(truck, side, tuple(_run(path, ticks_per_turn) for path in files))


def _run(path: Path, ticks_per_turn: float) -> SquareRun:
    rows = read_rows(path)
    poses = rows[:, 1:4].copy()
    poses[:, 2] = np.unwrap(poses[:, 2])
    wheel_angles = rows[:, [5, 4]] * (2.0 * math.pi / ticks_per_turn)
    turned = float(np.sum(wheel_angles[:, 1] - wheel_angles[:, 0]))
    direction: SquareDirection = "cw" if turned < 0.0 else "ccw"
    return SquareRun(direction, between(poses[0], poses[-1]), wheel_angles, str(path))
