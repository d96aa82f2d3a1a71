"""Poses that measured something else: a reflection, a marker that was taken for another.

A pose is compared with what odometry foresees from its neighbours (Hampel's identifier: Davies & Gather, JASA
1993). It counts as an outlier where those before it and those after it contradict it to the same side: what
happened to the robot itself is still there in the poses that follow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from omnimate.vehicle.se2 import rotate, wrap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array

NEIGHBOURS = 3  # on each side, whose median is compared with a pose
AROUND = 30  # poses on each side from which the usual size of a difference is taken, if it is larger there
MAD_TO_SIGMA = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
OUTLYING = 4.0  # standard deviations of a difference, beyond which noise is in fewer than 6 of 100,000 poses


def pose_outliers(pose: Array, driven: Array) -> NDArray[np.bool_]:
    """Return which numbers of poses `(M, 3)` neither those before nor those after them confirm, `(M, 3)`.

    Args:
        pose: Measured, in order of time [m, m, rad]; nan where unknown.
        driven: Where odometry takes the robot to at these times, from any start `(M, 3)`, headings unwrapped.
    """
    outlying = np.zeros(pose.shape, bool)
    known = np.flatnonzero(np.isfinite(pose).all(axis=1))
    if len(known) < 4 * NEIGHBOURS + 1:
        return outlying
    pose, driven = pose[known], driven[known]
    turned = np.unwrap(wrap(pose[:, 2] - driven[:, 2]))
    angle = np.median(_about(turned), axis=1)
    place = _about(pose[:, :2]) - rotate(angle[:, None], _about(driven[:, :2]).swapaxes(1, 2)).swapaxes(1, 2)
    off = np.concatenate([place, _about(turned)[:, None, :]], axis=1)
    middle = off[:, :, NEIGHBOURS]
    before = middle - np.median(off[:, :, :NEIGHBOURS], axis=2)
    after = middle - np.median(off[:, :, NEIGHBOURS + 1 :], axis=2)
    apart = np.where(before * after > 0.0, np.minimum(np.abs(before), np.abs(after)), 0.0)
    size = np.abs(before)
    deviation = MAD_TO_SIGMA * np.maximum(np.median(size, axis=0), np.median(_about(size, AROUND), axis=2))
    outlying[known] = apart > OUTLYING * deviation
    return outlying


def _about(values: Array, count: int = NEIGHBOURS) -> Array:
    """Return values (M, ...) with so many neighbours on each side, `(M, ..., 2 count + 1)`; ends repeat."""
    count = min(count, (len(values) - 1) // 2)
    padded = np.concatenate((values[count:0:-1], values, values[-2 : -count - 2 : -1]))
    return np.asarray(sliding_window_view(padded, 2 * count + 1, axis=0))
