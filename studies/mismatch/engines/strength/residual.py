"""What dead reckoning misses: between successive readings of the linkage, and between measured poses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.strength.drive import Drive, increments, turned

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

WINDOW = 0.1  # [s] from one reading, or one pose, to the next that is used; short against any manoeuvre


def residual(drive: Drive) -> dict[str, Array]:
    """Return what dead reckoning misses, by what was read.

    Returns:
        `linkage`: joint_a [rad], joint_b [rad] and link [m] at the end of each window, shape `(K, 3)`, absent
        with a single truck; `a` and `b`: forward [m], left [m] and yaw [rad] from pose to pose of the truck,
        shape `(M - 1, 3)`, absent where there are fewer than two poses.
    """
    paths = [drive.path(truck) for truck in range(drive.trucks)]
    missed = {}
    if drive.reading.shape[1]:
        missed["linkage"] = _of_linkage(drive, paths)
    for truck, poses in drive.poses.items():
        rows = spaced(poses.time)
        if len(rows) > 1:
            at = poses.time[rows]
            reckoned = np.stack([np.interp(at, drive.time, axis) for axis in paths[truck].T], axis=1)
            missed["ab"[truck]] = increments(reckoned) - increments(poses.pose[rows])
    return missed


def spaced(time: Array) -> NDArray[np.int64]:
    """Return the rows of times `(N,)` that are a window or more apart."""
    if len(time) < 2:
        return np.arange(len(time))
    period = float(np.median(np.diff(time)))
    return np.arange(0, len(time), max(1, round(WINDOW / period)))


def _of_linkage(drive: Drive, paths: list[Array]) -> Array:
    rows = spaced(drive.time)
    begin, end = drive.reading[rows[:-1]], drive.reading[rows[1:]]
    ahead, behind = (increments(path[rows]) for path in paths)
    # the link lies along x, its end on truck b in the origin
    lead = turned(begin[:, 0], ahead[:, :2])
    follow = turned(begin[:, 1], behind[:, :2])
    gap = lead - follow
    gap[:, 0] += begin[:, 2]
    along = np.arctan2(gap[:, 1], gap[:, 0])
    expected = np.stack(
        [
            begin[:, 0] + ahead[:, 2] - along,
            begin[:, 1] + behind[:, 2] - along,
            np.hypot(gap[:, 0], gap[:, 1]),
        ],
        axis=1,
    )
    missed = expected - end
    missed[:, :2] = (missed[:, :2] + np.pi) % (2.0 * np.pi) - np.pi
    return missed
