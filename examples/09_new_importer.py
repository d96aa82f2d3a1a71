"""Import a log of your own: two-wheel odometry as text, with a pose now and then.

A line `w TIME LEFT RIGHT` holds the wheels' counts, a line `p TIME X Y THETA` a measured pose.
Usage: python 09_new_importer.py LOG FOLDER
"""

import sys
from pathlib import Path

import numpy as np

import omnimate
from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Lap, Recording, Run

COLUMNS = {"w": 3, "p": 4}


def read(path: Path) -> dict[str, np.ndarray]:
    """Return the numbers of all lines of each kind, shape `(N, columns)`.

    Raises:
        SourceError: A line is of no known kind, or does not hold its numbers.
    """
    rows: dict[str, list[list[float]]] = {kind: [] for kind in COLUMNS}
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), start=1):
        kind, *cells = line.split() or [""]
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            values = []
        if len(values) != COLUMNS.get(kind):
            raise SourceError(
                f"{path}:{number}", f"{line!r}; expected 'w TIME LEFT RIGHT' or 'p TIME X Y THETA'"
            )
        rows[kind].append(values)
    return {kind: np.array(values).reshape(-1, COLUMNS[kind]) for kind, values in rows.items()}


def recording_from(path: Path) -> Recording:
    """Return the recording that a log holds."""
    rows = read(path)
    time, left, right = rows["w"].T

    # The robot as its owner describes it. The period between samples is taken from the data.
    truck = Truck(wheelbase=0.400, wheel_diameter_left=0.160, wheel_diameter_right=0.160)
    robot = single_truck("courier-3", truck, counts_per_turn=4096.0, period=0.05)

    # One series for each channel, on its own clock; `recording_of` brings them to one.
    wheels = {
        "a.left": Series(time, left, "counts", f"{path}, left"),
        "a.right": Series(time, right, "counts", f"{path}, right"),
    }
    poses = poses_of("a", rows["p"][:, 0], rows["p"][:, 1:]) if len(rows["p"]) else None
    run = Run("free", None, (Lap("none", float(time[0]), float(time[-1])),))
    return recording_of(robot, wheels, str(path), poses, run)


if __name__ == "__main__":
    recording = recording_from(Path(sys.argv[1]))
    omnimate.save_recording(recording, sys.argv[2])
    print(f"{sys.argv[2]}: {len(recording)} samples of {recording.vehicle.name}")
