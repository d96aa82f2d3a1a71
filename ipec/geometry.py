"""Plane geometry for compiled code that corrects poses."""

import math

from vehicle.compiled import Array, compiled
from vehicle.odometry import advance

advance_arc = compiled(advance)


@compiled
def wrap(angle: float) -> float:
    """Return the same angle [rad] in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def roll(pose: Array, left: float, right: float, wheelbase: float) -> None:
    """Move a pose `(3,)` along the exact arc of its wheels' travel [m], in place."""
    pose[0], pose[1], pose[2] = advance_arc((pose[0], pose[1], pose[2]), left, right, wheelbase)


@compiled
def direction(pose_a: Array, pose_b: Array) -> float:
    """Return the heading of the link [rad], C (10), O (1), with the quadrant that their atan leaves open."""
    return math.atan2(pose_a[1] - pose_b[1], pose_a[0] - pose_b[0])


@compiled
def follow(pose_b: Array, pose_a: Array, length: float, heading: float) -> None:
    """Put truck b on the link of a length [m] and heading [rad] behind truck a, C (16), O (5), in place."""
    pose_b[0] = pose_a[0] - length * math.cos(heading)
    pose_b[1] = pose_a[1] - length * math.sin(heading)


@compiled
def beyond(error: float, tolerance: float) -> float:
    """Return the part of an error that a tolerance to both sides does not explain."""
    return error - min(max(error, -tolerance), tolerance)
