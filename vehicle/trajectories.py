"""Odometry of each truck over a recording, and its error at the last absolute pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose, wrap

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Trajectory:
    """The odometry of a truck over a recording, through its first complete absolute pose if there is one."""

    truck: TruckName
    time: Array  # time of each sample [s], `(N,)`
    pose: Array  # pose at each sample x, y, theta [m, m, rad], `(N, 3)`
    fix: Array | None  # the last complete absolute pose, `(3,)`; None where there is none
    error: Array | None  # that pose minus odometry's at the same time, U (3.1), `(3,)`; None without a pose

    @property
    def length(self) -> float:
        """Length of the path [m]."""
        return float(np.hypot(*np.diff(self.pose[:, :2], axis=0).T).sum())


def trajectories(recording: Recording) -> tuple[Trajectory, ...]:
    """Return the trajectory of every truck of a recording.

    Raises:
        RecordingError: The two wheels of a truck are never present together.
    """
    return tuple(_trajectory(recording, truck) for truck in recording.vehicle.trucks)


def _trajectory(recording: Recording, truck: TruckName) -> Trajectory:
    if recording.poses is None:
        return Trajectory(truck, recording.time, dead_reckon(recording, truck), None, None)
    fixes = recording.poses.of(truck)
    whole = np.flatnonzero(np.isfinite(fixes.pose).all(axis=1))
    if not len(whole):
        return Trajectory(truck, recording.time, dead_reckon(recording, truck), None, None)
    first, last = fixes.pose[whole[[0, -1]]]
    rows = np.searchsorted(recording.time, fixes.time[whole[[0, -1]]]).clip(max=len(recording) - 1)
    path = dead_reckon(recording, truck)
    start = compose(first, between(path[rows[0]], path[0]))
    pose = dead_reckon(recording, truck, [start[0], start[1], wrap(start[2])])
    error = last - pose[rows[1]]
    error[2] = wrap(error[2])
    return Trajectory(truck, recording.time, pose, last, error)


def format_trajectories(paths: Iterable[Trajectory]) -> str:
    """Return time and pose of every truck in the columns of `poses.csv`, without standard deviations."""
    lines = ["t,body,x,y,theta"]
    for path in paths:
        lines += [
            f"{time:.6f},{path.truck},{x:.6f},{y:.6f},{theta:.7f}"
            for time, (x, y, theta) in zip(path.time.tolist(), path.pose.tolist(), strict=True)
        ]
    return "\n".join([*lines, ""])
