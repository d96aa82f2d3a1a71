"""A trajectory that knows the past only: odometry, drawn slowly to what was read and measured before.

A model that is linear about a trajectory made of the readings themselves has the readings' noise on both
sides of its regression: columns then explain their own noise (errors in variables; Ljung, System
Identification, 1999, section 7.5). Here every pose depends on odometry and on earlier samples only, so that
the error of a reading is not in the column that has to explain it.
"""

from __future__ import annotations

import math

import numpy as np

from omnimate.vehicle.arcs import sinc_of
from omnimate.vehicle.compiled import Array, IntArray, compiled
from omnimate.vehicle.se2 import rotate_xy, wrap_angle

FORGETTING = 1.0  # [s] within which the trajectory comes to what was measured: long against a sample's noise


@compiled
def follow_poses(
    twist: Array, time: Array, start: Array, pose_time: Array, pose: Array, after: IntArray
) -> Array:
    """Return poses `(N, 3)` of a truck along its twists, drawn to earlier measured poses.

    Args:
        twist: Way forward [m], way to the left [m], yaw [rad] of each step, shape `(N - 1, 3)`.
        time: Times of the samples, shape `(N,)` [s].
        start: First pose, shape `(3,)`.
        pose_time: Times of the measured poses, ascending, shape `(P,)` [s].
        pose: Measured x [m], y [m], heading [rad]; nan where not measured, shape `(P, 3)`.
        after: Number of the first sample that is not before each pose, ascending, shape `(P,)`.
    """
    path = np.empty((len(time), 3))
    path[0] = start
    measured, last = 0, np.full(3, -math.inf)
    pull = np.zeros(3)
    for step in range(len(time)):
        if step > 0:
            _advance(path, twist[step - 1], step)
            path[step] += pull
            pull[:] = 0.0
        while measured < len(after) and after[measured] <= step:
            for axis in range(3):
                if np.isnan(pose[measured, axis]):
                    continue
                now = path[step, axis]
                if step > 0 and time[step] > time[step - 1]:
                    back = (time[step] - pose_time[measured]) / (time[step] - time[step - 1])
                    now -= back * (path[step, axis] - path[step - 1, axis])
                off = pose[measured, axis] - now
                if axis == 2:
                    off = wrap_angle(off)
                since = pose_time[measured] - last[axis]
                share = 1.0 - math.exp(-max(since, 0.0) / FORGETTING) if since < math.inf else 0.0
                pull[axis] += share * (off - pull[axis])
                last[axis] = pose_time[measured]
            measured += 1
    return path


@compiled
def follow_linkage(lead: Array, twist: Array, time: Array, behind: Array) -> Array:
    """Return poses `(N, 3)` of truck b along its twists, drawn to where the linkage had it before.

    Args:
        lead: Poses of truck a, shape `(N, 3)`.
        twist: Of truck b, as in `follow_poses`.
        time: Likewise.
        behind: Pose of truck b in the frame of truck a by the readings, shape `(N, 3)` [m, m, rad].
    """
    path = np.empty((len(time), 3))
    path[0] = _placed(lead[0], behind[0])
    off = np.zeros(3)
    for step in range(1, len(time)):
        _advance(path, twist[step - 1], step)
        share = 1.0 - math.exp(-(time[step] - time[step - 1]) / FORGETTING)
        path[step] += share * off
        off[:] = _placed(lead[step], behind[step]) - path[step]
        off[2] = wrap_angle(off[2])
    return path


@compiled
def _placed(lead: Array, behind: Array) -> Array:
    """Return a pose that is given in the frame of another."""
    x, y = rotate_xy(lead[2], behind[0], behind[1])
    return np.array([lead[0] + x, lead[1] + y, lead[2] + behind[2]])


@compiled
def _advance(path: Array, twist: Array, step: int) -> None:
    """Write the pose after one exact arc with sideways motion."""
    half = 0.5 * twist[2]
    x, y = rotate_xy(path[step - 1, 2] + half, twist[0] * sinc_of(half), twist[1] * sinc_of(half))
    path[step, 0], path[step, 1] = path[step - 1, 0] + x, path[step - 1, 1] + y
    path[step, 2] = path[step - 1, 2] + twist[2]
