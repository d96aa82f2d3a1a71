"""What the real part of `python -m studies prove` draws of robots that are described wrongly."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.figures.floor_plan import Track, plot_floor_plan
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import wrap
from studies.figures.turns import plot_turns

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array
    from studies.mismatch.real_rows import RobotRow


def draw_labyrinth(row: RobotRow, folder: Path) -> None:
    """Draw the one drive as measured, and odometry as described and as corrected, each laid onto it.

    Raises:
        PlotError: the file cannot be written.
    """
    assert row.recordings[0].poses is not None  # the importer gives them
    tracks = [
        Track("measured", row.recordings[0].poses.pose[:, :2]),
        Track("odometry as described", _laid(row.recordings[0]), dashed=True),
        Track("odometry as the first look corrects it", _laid(row.corrected[0]), dashed=True),
    ]
    plot_floor_plan(tracks, folder / "labyrinth.png", title="labyrinth_tuc, 30 s")


def draw_husky(row: RobotRow, folder: Path) -> None:
    """Draw the turn of every window: by the wheels of the described robot, and as measured.

    Raises:
        PlotError: the file cannot be written.
    """
    pairs = np.array([_turned(recording) for recording in row.recordings])
    old, new = (each[0].vehicle.trucks["a"].wheelbase for each in (row.recordings, row.corrected))
    title = f"drive_ugv: {len(pairs)} windows of 2 s"
    wheel = row.corrected[0].vehicle.trucks["a"], row.recordings[0].vehicle.trucks["a"]
    rolls = (wheel[0].wheel_diameter_left + wheel[0].wheel_diameter_right) / (
        wheel[1].wheel_diameter_left + wheel[1].wheel_diameter_right
    )
    plot_turns(pairs[:, 0], pairs[:, 1], new / old / rolls, folder / "husky.png", title=title)


def _laid(recording: Recording) -> Array:
    """Return odometry (N, 2), turned and shifted as a whole so that it lies best on the positions [m]."""
    assert recording.poses is not None  # as above
    path = dead_reckon(recording)
    at, goal = recording.poses.time, recording.poses.pose[:, 0] + 1j * recording.poses.pose[:, 1]
    way = path[:, 0] + 1j * path[:, 1]
    seen = np.interp(at, recording.time, way.real) + 1j * np.interp(at, recording.time, way.imag)
    turn = np.vdot(seen - seen.mean(), goal - goal.mean())
    laid = (way - seen.mean()) * turn / abs(turn) + goal.mean()
    return np.stack([laid.real, laid.imag], axis=1)


def _turned(recording: Recording) -> tuple[float, float]:
    """Return how far a truck turned by its wheels, and as measured (less than half a turn) [rad]."""
    assert recording.poses is not None  # as above
    poses, path = recording.poses, dead_reckon(recording)
    first, last = np.interp(poses.time[[0, -1]], recording.time, path[:, 2])
    return float(last - first), float(wrap(poses.pose[-1, 2] - poses.pose[0, 2]))
