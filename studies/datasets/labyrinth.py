"""The Labyrinth data as a recording: a small differential robot, as its own readme describes it.

The readme is wrong, and this robot follows it on purpose: the columns that it calls right and left are
exchanged, and its wheel distance is about half of the real one. The poses are positions without headings.
Source: T. Pfeifer, TU Chemnitz, libRSF, datasets/Indoor_UWB.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.parameters import Channel, Truck
from omnimate.vehicle.recording import Lap, Recording, Run
from omnimate.vehicle.se2 import Array

INPUT, TRUTH = "Indoor_UWB_Input.txt", "Indoor_UWB_GT.txt"
# The readme gives speeds over the floor, so the wheel diameter is free: it only turns metres into counts.
WHEEL_DIAMETER = 0.1  # [m]
COUNTS_PER_TURN = 31416.0  # one count is 10 micrometres
_COLUMNS = {"odom2diff": 9, "point2": 8}


def each_recording(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield the only drive of the folder, as `run-01`; SourceError where a file is missing or damaged."""
    folder = Path(folder)
    odometry, truth = _rows(folder / INPUT, "odom2diff"), _rows(folder / TRUTH, "point2")
    time, source = odometry[:, 0], folder / INPUT
    bases = np.unique(odometry[:, 4])
    if len(bases) != 1:
        raise SourceError(
            source, f"distance between wheels from {bases[0]:g} to {bases[-1]:g} m; expected one"
        )
    truck = Truck(float(bases[0]), WHEEL_DIAMETER, WHEEL_DIAMETER)
    robot = single_truck("labyrinth", truck, COUNTS_PER_TURN, float(np.median(np.diff(time))))
    wheels: dict[Channel, Series] = {
        "a.right": Series(time, odometry[:, 1], "m/s", f"{source}, column 3"),
        "a.left": Series(time, odometry[:, 2], "m/s", f"{source}, column 4"),
    }
    place = np.column_stack((truth[:, 1:3], np.full(len(truth), np.nan)))
    run = Run("free", None, (Lap("none", float(time[0]), float(time[-1])),))
    yield "run-01", recording_of(robot, wheels, str(source), poses_of("a", truth[:, 0], place), run)


def _rows(path: Path, kind: str) -> Array:
    """Return the numbers of all lines of a kind, `(N, columns - 1)`."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SourceError(path, f"cannot be read: {error}") from error
    rows = []
    for number, cells in enumerate(map(str.split, lines), start=1):
        if not cells or cells[0] != kind:
            continue
        try:
            row = [float(cell) for cell in cells[1:]]
        except ValueError as error:
            raise SourceError(f"{path}:{number}", f"{error}") from error
        if len(row) != _COLUMNS[kind] - 1 or not np.isfinite(row).all():
            raise SourceError(
                f"{path}:{number}", f"expected {_COLUMNS[kind] - 1} finite numbers after {kind}"
            )
        rows.append(row)
    if len(rows) < 2:
        raise SourceError(path, f"{len(rows)} line(s) of {kind}; expected a drive")
    return np.array(rows, np.float64)
