"""The DRIVE data of a Clearpath Husky as recordings: one window of two seconds each.

It is a skid-steer robot on snow, grass or gravel. Its nominal track and wheels are those of its data sheet;
its odometry has large errors because its wheels slip. Poses are those of lidar ICP (10 Hz), each window from
its first pose, so that windows cannot be joined. The speeds of the wheels are summed by the trapezoid rule at
20 Hz; quantities without a place in a recording folder (gyro, accelerometer, roll, pitch) are left out.
Source: norlab-ulaval/DRIVE, Universite Laval.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.parameters import Drive, Truck
from omnimate.vehicle.recording import Lap, Recording, Run
from omnimate.vehicle.se2 import Array

WINDOWS = "husky_windows.npz"
NOMINAL = Truck(0.55, 0.33, 0.33)
PERIOD = 0.05  # [s]
COUNTS_PER_TURN = 100_000.0  # chosen here: the data contain speeds and no counts
DRIVES = (Drive("a.left", 11, 0x20B, 1, COUNTS_PER_TURN), Drive("a.right", 12, 0x20C, 1, COUNTS_PER_TURN))
_NEEDED = ("cmd_left", "cmd_right", "left_wheel_vel", "right_wheel_vel", "icp_x", "icp_y", "icp_yaw")


def each_recording(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield every window with its name, from `window-000` on; SourceError where the file is not DRIVE's."""
    path = Path(folder) / WINDOWS
    data = _arrays(path)
    for number in range(len(data["icp_x"])):
        window = {name: array[number] for name, array in data.items()}
        yield f"window-{number:03}", _recording(window, f"{path}, window {number}")


def _recording(window: Mapping[str, Array], source: str) -> Recording:
    time: Array = PERIOD * np.arange(len(window["icp_x"]), dtype=np.float64)
    robot = replace(single_truck("husky", NOMINAL, COUNTS_PER_TURN, PERIOD), drives=DRIVES)
    left, right = (
        Series(time, window[f"{side}_wheel_vel"], "rad/s", f"{source}, {side}_wheel_vel")
        for side in ("left", "right")
    )
    pose = np.column_stack([window[name] for name in ("icp_x", "icp_y", "icp_yaw")])
    fresh = np.concatenate(([True], np.any(np.diff(pose, axis=0) != 0.0, axis=1)))  # others repeat a pose
    return recording_of(
        robot,
        {"a.left": left, "a.right": right},
        source,
        poses_of("a", time[fresh], pose[fresh]),
        Run("free", None, (Lap("none", 0.0, float(time[-1])),)),
        np.column_stack([window["cmd_left"], window["cmd_right"]]),
    )


def _arrays(path: Path) -> dict[str, Array]:
    """Return the needed arrays `(W, 40)`."""
    try:
        with np.load(path, allow_pickle=False) as file:
            data = {name: np.asarray(file[name], np.float64) for name in _NEEDED}
    except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
        raise SourceError(path, f"cannot be read: {error}") from error
    shape = data["icp_x"].shape
    for name, array in data.items():
        if array.ndim != 2 or array.shape != shape or not np.isfinite(array).all():
            raise SourceError(
                path, f"{name} of shape {array.shape}; expected finite numbers of shape {shape}"
            )
    return data
