"""The OptiOdom data as recordings: differential drives with motion capture, one recording a run.

Source: Sousa et al., J Intell Robot Syst 105:39 (2022); `calib.optiodom` knows the files.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from calib.kinematics import Differential
from calib.optiodom import read_metadata, read_numbers
from calib.optiodom_sets import find_sets, read_set
from imports.clock import recording_of
from imports.errors import SourceError
from imports.poses import poses_of
from imports.robots import single_truck
from imports.series import Series
from vehicle.recording import Lap, Run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from calib.drives import Drive
    from vehicle.parameters import VehicleParameters
    from vehicle.recording import Direction, Recording

_PERIOD = 0.05  # [s] of the robot's cycle


def recordings_of(folder: Path | str) -> list[Recording]:
    """Return the runs of all differential sets under a folder, in order.

    Raises:
        OptiOdomError: there is no set, or a damaged one.
        SourceError: all of them are of the tricycle.
    """
    return [recording for _, recording in each_run(folder)]


def each_run(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield every run under a folder with its name, such as `diff/square/230620202042/run-01`.

    Raises:
        OptiOdomError, SourceError: as `recordings_of`.
    """
    sets, tricycles = differential_sets(folder)
    if not sets:
        raise SourceError(
            folder,
            f"{len(tricycles)} set(s) of the tricycle; a recording folder holds differential drives only: "
            "its channels are two drive wheels, and a steered one has no place in them",
        )
    for one in sets:
        yield from _runs(one)


def differential_sets(folder: Path | str) -> tuple[list[Path], list[Path]]:
    """Return the sets of the differential robot under a folder, and those of other robots.

    Raises:
        OptiOdomError: there is no set at all.
    """
    found = find_sets(folder)
    mine = [one for one in found if read_metadata(one).get("type", [""])[0] == "diff"]
    return mine, [one for one in found if one not in mine]


def _runs(folder: Path) -> Iterator[tuple[str, Recording]]:
    data, metadata = read_set(folder), read_metadata(folder)
    assert isinstance(data.kinematics, Differential)  # differential_sets saw to it
    resolution = math.prod(read_numbers(folder, metadata, key, 1)[0] for key in ("ngear", "encRes"))
    robot = single_truck("optiodom-diff", data.kinematics.truck, resolution, _PERIOD)
    side = read_numbers(folder, metadata, "L", 1)[0] if data.path == "square" else None
    for drive in data.drives:
        number = Path(drive.source).name.split("_run-")[1].split(".")[0]
        yield f"{data.name}/run-{number}", _recording(robot, drive, resolution, side)


def _recording(robot: VehicleParameters, drive: Drive, resolution: float, side: float | None) -> Recording:
    counts = np.rint(drive.readings * (resolution / (2.0 * math.pi)))
    left, right = (
        Series(drive.time, column, "counts", f"{drive.source}, {name}")
        for column, name in zip(counts.T, ("odoL", "odoR"), strict=True)
    )
    turned = float(counts[-1, 1] - counts[-1, 0])
    direction: Direction = "none" if side is None else "cw" if turned < 0.0 else "ccw"
    lap = Lap(direction, float(drive.time[0]), float(drive.time[-1]))
    return recording_of(
        robot,
        {"a.left": left, "a.right": right},
        drive.source,
        poses_of("a", drive.fix_time, drive.pose),
        Run("free" if side is None else "umbmark", side, (lap,)),
    )
