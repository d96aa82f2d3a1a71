"""The OptiOdom data as recordings: differential drives with motion capture, a recording for each run.

Source: Sousa et al., J Intell Robot Syst 105:39 (2022); `studies.datasets.optiodom.files` reads the files.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.parameters import VehicleParameters
from omnimate.vehicle.recording import Direction, Lap, Recording, Run
from studies.datasets.optiodom.drives import read_set
from studies.datasets.optiodom.files import find_sets, read_metadata, read_numbers

_PERIOD = 0.05  # [s] of the robot's cycle


def each_recording(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield every run under a folder with its name, such as `diff/square/230620202042/run-01`.

    Raises:
        OptiOdomError: There is no set, or a set is damaged.
        SourceError: All sets are of the tricycle.
    """
    sets, tricycles = differential_sets(folder)
    if not sets:
        raise SourceError(
            folder,
            f"{len(tricycles)} set(s) of the tricycle; a recording folder holds differential drives only: "
            "its channels are two drive wheels, and a steered one has no place in them",
        )
    for path in sets:
        yield from _runs(path)


def differential_sets(folder: Path | str) -> tuple[list[Path], list[Path]]:
    """Return the sets of the differential robot under a folder, and those of other robots.

    Raises:
        OptiOdomError: There is no set.
    """
    sets = find_sets(folder)
    differential = [path for path in sets if read_metadata(path).get("type", [""])[0] == "diff"]
    return differential, [path for path in sets if path not in differential]


def _runs(folder: Path) -> Iterator[tuple[str, Recording]]:
    data = read_set(folder)
    assert isinstance(data.kinematics, Differential)  # differential_sets chose them
    resolution = data.ticks_per_turn
    robot = single_truck("optiodom-diff", data.kinematics.truck, resolution, _PERIOD)
    is_square = data.path == "square"
    side = read_numbers(folder, read_metadata(folder), "L", 1)[0] if is_square else None
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
