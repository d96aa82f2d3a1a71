"""Trajectories as the TUM RGB-D benchmark writes them, which evo reads: `time x y z qx qy qz qw` per line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.frames import NANOSECOND, nanoseconds
from omnimate.vehicle.atomic import write_text

if TYPE_CHECKING:
    from pathlib import Path as FilePath

    from omnimate.files.exporters.drive import Drive
    from omnimate.vehicle.se2 import Array


def write_tum(drive: Drive, target: FilePath) -> tuple[FilePath, ...]:
    """Write every trajectory of a drive to a separate file, and return the paths.

    `drive.tum` gives `drive-odometry_a.tum`, with `ipec` where there is a linkage, and `measured` where there
    are complete absolute poses.
    """
    trajectories = [(path.name, path.time, path.pose) for path in drive.paths]
    if (poses := drive.recording.poses) is not None:
        for truck in drive.recording.vehicle.trucks:
            measured = poses.of(truck)
            if np.isfinite(measured.pose).all(axis=1).any():
                trajectories.append((f"measured_{truck}", measured.time, measured.pose))
    written = []
    for name, time, pose in trajectories:
        written.append(target.with_name(f"{target.stem}-{name}{target.suffix}"))
        write_text(written[-1], tum_text(time, pose))
    return tuple(written)


def tum_text(time: Array, pose: Array) -> str:
    """Return times `(N,)` [s] and poses x, y, theta `(N, 3)` [m, m, rad] as lines, without those with nan."""
    known = np.isfinite(pose).all(axis=1)
    lines = []
    for at, (x, y, theta) in zip(time[known].tolist(), pose[known].tolist(), strict=True):
        whole, rest = divmod(nanoseconds(at), NANOSECOND)
        half = 0.5 * theta
        lines.append(f"{whole}.{rest:09d} {x!r} {y!r} 0 0 0 {math.sin(half)!r} {math.cos(half)!r}\n")
    return "".join(lines)
