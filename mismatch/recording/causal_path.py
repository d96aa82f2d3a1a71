"""A causal trajectory: odometry, corrected slowly by earlier readings and measured poses.

A model that is linear about a trajectory made of the readings themselves has their noise on both sides of
its regression: columns then explain their own noise (errors in variables; Ljung, System Identification,
1999, section 7.5). Here every pose depends on odometry and on earlier samples only, so that the error of a
reading is not in the column that has to explain it.
"""

from __future__ import annotations

import math

import numpy as np

from omnimate.vehicle.arcs import glide
from omnimate.vehicle.compiled import Array, IntArray, compiled
from omnimate.vehicle.se2 import rotate_xy, wrap_angle

FORGETTING = 1.0  # [s] time constant of the correction: long against the samples, whose noise it averages


@compiled
def follow_poses(
    twist: Array, time: Array, start: Array, pose_time: Array, pose: Array, after: IntArray
) -> Array:
    """Return poses `(N, 3)` of a truck along its twists, corrected by earlier measured poses.

    Twists (N - 1, 3) are travel forward and to the left [m] and yaw [rad] of each step between times (N,)
    [s]. Poses (P, 3) [m, m, rad], nan where not measured, are of ascending times (P,); `after` (P,) are the
    numbers of the first samples that are not before them.
    """
    path = np.empty((len(time), 3))
    path[0] = start
    measured, last = 0, np.full(3, -math.inf)
    correction = np.zeros(3)
    for step in range(len(time)):
        if step > 0:
            _advance(path, twist[step - 1], step)
            path[step] += correction
            correction[:] = 0.0
        while measured < len(after) and after[measured] <= step:
            for axis in range(3):
                if np.isnan(pose[measured, axis]):
                    continue
                expected = path[step, axis]
                if step > 0 and time[step] > time[step - 1]:
                    part = (time[step] - pose_time[measured]) / (time[step] - time[step - 1])
                    expected -= part * (path[step, axis] - path[step - 1, axis])
                error = pose[measured, axis] - expected
                if axis == 2:
                    error = wrap_angle(error)
                since = pose_time[measured] - last[axis]
                gain = 1.0 - math.exp(-max(since, 0.0) / FORGETTING) if since < math.inf else 0.0
                correction[axis] += gain * (error - correction[axis])
                last[axis] = pose_time[measured]
            measured += 1
    return path


@compiled
def follow_linkage(lead: Array, twist: Array, time: Array, behind: Array) -> Array:
    """Return poses `(N, 3)` of truck b along its twists, corrected by earlier readings of the linkage.

    `lead` (N, 3) are poses of truck a, and `behind` (N, 3) [m, m, rad] those of truck b in its frame by the
    readings; twists and times are as in `follow_poses`.
    """
    path = np.empty((len(time), 3))
    path[0] = _composed(lead[0], behind[0])
    error = np.zeros(3)
    for step in range(1, len(time)):
        _advance(path, twist[step - 1], step)
        gain = 1.0 - math.exp(-(time[step] - time[step - 1]) / FORGETTING)
        path[step] += gain * error
        error[:] = _composed(lead[step], behind[step]) - path[step]
        error[2] = wrap_angle(error[2])
    return path


@compiled
def _composed(lead: Array, behind: Array) -> Array:
    """Return the world pose (3,) of truck b from that of truck a and its own relative to a."""
    x, y = rotate_xy(lead[2], behind[0], behind[1])
    return np.array([lead[0] + x, lead[1] + y, lead[2] + behind[2]])


@compiled
def _advance(path: Array, twist: Array, step: int) -> None:
    """Write the pose of a step after one exact arc with sideways motion."""
    path[step] = path[step - 1]
    glide(path[step], twist[0], twist[1], twist[2])
