"""Outliers among measured poses: reflections, and markers that were confused.

A pose is compared with the prediction of odometry from its neighbours (Hampel identifier: Davies & Gather,
JASA 1993). It is an outlier where those before it and those after it differ from it to the same side: a
motion of the robot itself is still present in the poses that follow.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from omnimate.vehicle.se2 import rotate, wrap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array

NEIGHBOURS = 3  # poses on each side, with whose median a pose is compared
# Poses on each side for a local estimate of scale, used where it exceeds the global one.
SCALE_NEIGHBOURS = 30
MAD_TO_SIGMA = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
OUTLIER_SIGMAS = 4.0  # normal noise exceeds it with a probability of 6.3e-5


def pose_outliers(pose: Array, driven: Array) -> NDArray[np.bool_]:
    """Return which values of poses `(M, 3)`, in order of time and nan where unknown, are outliers, `(M, 3)`.

    `driven` (M, 3) are poses by odometry at these times, from any start, headings unwrapped.
    """
    outlying = np.zeros(pose.shape, bool)
    known = np.flatnonzero(np.isfinite(pose).all(axis=1))
    if len(known) < 4 * NEIGHBOURS + 1:
        return outlying
    pose, driven = pose[known], driven[known]
    turned = np.unwrap(wrap(pose[:, 2] - driven[:, 2]))
    angle = np.median(_with_neighbours(turned), axis=1)
    place = _with_neighbours(pose[:, :2]) - rotate(
        angle[:, None], _with_neighbours(driven[:, :2]).swapaxes(1, 2)
    ).swapaxes(1, 2)
    error = np.concatenate([place, _with_neighbours(turned)[:, None, :]], axis=1)
    middle = error[:, :, NEIGHBOURS]
    before = middle - np.median(error[:, :, :NEIGHBOURS], axis=2)
    after = middle - np.median(error[:, :, NEIGHBOURS + 1 :], axis=2)
    difference = np.where(before * after > 0.0, np.minimum(np.abs(before), np.abs(after)), 0.0)
    size = np.abs(before)
    deviation = MAD_TO_SIGMA * np.maximum(
        np.median(size, axis=0), np.median(_with_neighbours(size, SCALE_NEIGHBOURS), axis=2)
    )
    outlying[known] = difference > OUTLIER_SIGMAS * deviation
    return outlying


def _with_neighbours(values: Array, count: int = NEIGHBOURS) -> Array:
    """Return values (M, ...) with `count` neighbours on each side, `(M, ..., 2 count + 1)`; ends reflect."""
    count = min(count, (len(values) - 1) // 2)
    padded = np.concatenate((values[count:0:-1], values, values[-2 : -count - 2 : -1]))
    return np.asarray(sliding_window_view(padded, 2 * count + 1, axis=0))
