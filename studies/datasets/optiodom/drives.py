"""Any set of the OptiOdom data as drives for least squares: differential robot or tricycle, any path.

See `studies.datasets.optiodom.files` for the format. The ticks of a row are those of its cycle, so they
lead to the pose of the same row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential, Kinematics
from omnimate.vehicle.parameters import ParameterError, Truck
from studies.datasets.optiodom.files import OptiOdomError, read_metadata, read_numbers, read_rows
from studies.datasets.optiodom.tricycle import Tricycle


@dataclass(frozen=True, slots=True)
class DriveSet:
    """All runs of one folder."""

    name: str  # name of the set, robot/path/date, as in the data
    robot: str  # kind of robot: diff or tricyc
    path: str  # kind of path: circular, free, ivanjko or square
    ticks_per_turn: float  # ticks of the encoders per turn of a wheel
    kinematics: Kinematics  # model of the nominal robot
    drives: tuple[Drive, ...]  # a drive for each run


def read_set(folder: Path | str) -> DriveSet:
    """Return the runs of an OptiOdom folder.

    Raises:
        OptiOdomError: The folder is not an OptiOdom set, or a file in it is damaged.
    """
    folder = Path(folder).resolve()
    metadata = read_metadata(folder)
    ticks = math.prod(read_numbers(folder, metadata, key, 1)[0] for key in ("ngear", "encRes"))
    kinematics = _kinematics(folder, metadata)
    files = sorted(folder.glob("*_run-[0-9][0-9].csv*"))
    if not files:
        raise OptiOdomError(folder, "no *_run-NN.csv in it")
    drives = tuple(_drive(file, ticks, kinematics) for file in files)
    name, path = "/".join(folder.parts[-3:]), folder.parts[-2]
    return DriveSet(name, metadata["type"][0], path, ticks, kinematics, drives)


def _kinematics(folder: Path, metadata: dict[str, list[str]]) -> Kinematics:
    kind = metadata.get("type", [""])[0]
    wheelbase = read_numbers(folder, metadata, "Li", 1)[0]
    try:
        if kind == "diff":
            right, left = read_numbers(folder, metadata, "Di", 2)
            return Differential(Truck(wheelbase, left, right))
        if kind == "tricyc":
            return Tricycle(wheelbase, read_numbers(folder, metadata, "Di", 1)[0])
    except ParameterError as error:
        raise OptiOdomError(folder, str(error)) from error
    raise OptiOdomError(folder, f"robot type {kind!r}; expected diff or tricyc")


def _drive(path: Path, ticks_per_turn: float, kinematics: Kinematics) -> Drive:
    rows = read_rows(path)
    radians = 2.0 * math.pi / ticks_per_turn
    if isinstance(kinematics, Differential):
        readings = np.cumsum(rows[:, [5, 4]] * radians, axis=0)
    else:
        readings = np.stack([np.cumsum(rows[:, 4] * radians), rows[:, 5]], axis=-1)
    return Drive(rows[:, 0], readings, rows[:, 0], rows[:, 1:4], np.full((len(rows), 3), np.nan), str(path))
