"""The DRIVE data of a Clearpath Husky as recordings: one window of two seconds each.

A skid-steer robot on snow, grass or gravel: its nominal track and wheels are those of its data sheet, and its
odometry is far off, for its wheels slip. Poses are those of lidar ICP (10 Hz), each window from its own first
pose, so that windows cannot be joined. The wheels' speeds are summed by the trapezoid rule at 20 Hz; what
stands in no recording folder (gyro, accelerometer, roll, pitch) is left out.
Source: norlab-ulaval/DRIVE, Universite Laval.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imports.clock import recording_of
from imports.errors import SourceError
from imports.poses import poses_of
from imports.robots import single_truck
from imports.series import Series
from vehicle.parameters import Truck
from vehicle.recording import Lap, Run

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from vehicle.recording import Recording
    from vehicle.se2 import Array

WINDOWS = "husky_windows.npz"
NOMINAL = Truck(0.55, 0.33, 0.33)
PERIOD = 0.05  # [s]
COUNTS_PER_TURN = 100_000.0  # a unit of ours: the data have speeds, no counts
_NEEDED = ("cmd_left", "cmd_right", "left_wheel_vel", "right_wheel_vel", "icp_x", "icp_y", "icp_yaw")


def recordings_of(folder: Path | str) -> list[Recording]:
    """Return the windows of a DRIVE folder, in order.

    Raises:
        SourceError: the file is not there, or is no such file.
    """
    return [recording for _, recording in each_window(folder)]


def each_window(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield every window with its name, `window-000` onwards; errors as `recordings_of`."""
    path = Path(folder) / WINDOWS
    data = _arrays(path)
    for number in range(len(data["icp_x"])):
        window = {name: array[number] for name, array in data.items()}
        yield f"window-{number:03}", _recording(window, f"{path}, window {number}")


def _recording(window: Mapping[str, Array], source: str) -> Recording:
    time: Array = PERIOD * np.arange(len(window["icp_x"]), dtype=np.float64)
    robot = single_truck("husky", NOMINAL, COUNTS_PER_TURN, PERIOD, driven=True)
    left, right = (
        Series(time, window[f"{side}_wheel_vel"], "rad/s", f"{source}, {side}_wheel_vel")
        for side in ("left", "right")
    )
    pose = np.column_stack([window[name] for name in ("icp_x", "icp_y", "icp_yaw")])
    fresh = np.concatenate(([True], np.any(np.diff(pose, axis=0) != 0.0, axis=1)))  # the rest is held over
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
