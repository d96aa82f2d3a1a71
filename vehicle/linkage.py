"""The linkage: conversion between two truck poses, and one truck pose with the three linkage readings.

`link` is the line from the centre of b to the centre of a; joint angles are truck heading minus link
heading. Poses are `(..., 3)`: x [m], y [m], theta [rad].
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def linkage_of(pose_a: ArrayLike, pose_b: ArrayLike) -> tuple[Array, Array, Array]:
    """Return joint_a [rad], joint_b [rad] in (-pi, pi] and the length [m] between two trucks, C (10)-(11)."""
    a, b = np.asarray(pose_a, np.float64), np.asarray(pose_b, np.float64)
    dx, dy = a[..., 0] - b[..., 0], a[..., 1] - b[..., 1]
    heading = np.arctan2(dy, dx)
    return wrap(a[..., 2] - heading), wrap(b[..., 2] - heading), np.hypot(dx, dy)


def follower(pose_a: ArrayLike, joint_a: ArrayLike, joint_b: ArrayLike, length: ArrayLike) -> Array:
    """Return the pose of truck b from that of truck a, C (16)."""
    a = np.asarray(pose_a, np.float64)
    heading = a[..., 2] - np.asarray(joint_a, np.float64)
    length = np.asarray(length, np.float64)
    x = a[..., 0] - length * np.cos(heading)
    y = a[..., 1] - length * np.sin(heading)
    return np.stack(np.broadcast_arrays(x, y, heading + np.asarray(joint_b, np.float64)), axis=-1)


@compiled
def link_heading(pose_a: Array, pose_b: Array) -> float:
    """Return the heading of the link [rad], C (10), O (1), in the quadrant that their atan leaves open."""
    return math.atan2(pose_a[1] - pose_b[1], pose_a[0] - pose_b[0])


@compiled
def place_follower(pose_b: Array, pose_a: Array, length: float, heading: float) -> None:
    """Place truck b behind truck a for length [m] and heading [rad] of the link, C (16), O (5), in place."""
    pose_b[0] = pose_a[0] - length * math.cos(heading)
    pose_b[1] = pose_a[1] - length * math.sin(heading)
