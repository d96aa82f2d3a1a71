"""Poses in the plane for compiled code: SE(2), exact arcs, and truck b behind truck a.

The same laws as in `se2`, `arcs` and `linkage`, on one pose at a time: an array `(3,)` of x [m], y [m] and
theta [rad]. Results are written into arrays that exist, because making one costs more than the arithmetic.
"""

import math

from omnimate.vehicle.arcs import advance, sinc_of
from omnimate.vehicle.compiled import Array, compiled

advance_arc = compiled(advance)
sinc = compiled(sinc_of)


@compiled
def wrap(angle: float) -> float:
    """Return the same angle [rad] in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def rotate(angle: float, x: float, y: float) -> tuple[float, float]:
    """Return a vector [m] turned counter-clockwise by an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x - sin * y, sin * x + cos * y


@compiled
def transform(pose: Array, x: float, y: float) -> tuple[float, float]:
    """Return a point [m], given in the frame of a pose `(3,)`, in the frame that holds the pose."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y


@compiled
def compose(out: Array, first: Array, second: Array) -> None:
    """Write first (+) second of two poses `(3,)`; `out` may be one of them."""
    x, y = transform(first, second[0], second[1])
    out[2] = first[2] + second[2]
    out[0], out[1] = x, y


@compiled
def rotation(out: Array, angle: float) -> None:
    """Write the matrix `(3, 3)` that turns x, y, theta of the world into a frame at an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    out[:] = 0.0
    out[0, 0], out[0, 1] = cos, sin
    out[1, 0], out[1, 1] = -sin, cos
    out[2, 2] = 1.0


@compiled
def transport(out: Array, increment: Array) -> None:
    """Write how an error before an increment `(3,)` becomes one after it, `(3, 3)`: Ad of its inverse."""
    cos, sin = math.cos(increment[2]), math.sin(increment[2])
    out[0, 0], out[0, 1] = cos, sin
    out[1, 0], out[1, 1] = -sin, cos
    out[0, 2] = sin * increment[0] - cos * increment[1]
    out[1, 2] = cos * increment[0] + sin * increment[1]
    out[2, 0], out[2, 1], out[2, 2] = 0.0, 0.0, 1.0


@compiled
def roll(pose: Array, left: float, right: float, wheelbase: float) -> None:
    """Move a pose `(3,)` along the exact arc of its wheels' travel [m], in place."""
    pose[0], pose[1], pose[2] = advance_arc((pose[0], pose[1], pose[2]), left, right, wheelbase)


@compiled
def glide(pose: Array, forward: float, left: float, yaw: float) -> None:
    """Move a pose `(3,)` forward and to the left [m] on the arc of its turn [rad], in place."""
    half = 0.5 * yaw
    chord = sinc(half)
    x, y = rotate(pose[2] + half, chord * forward, chord * left)
    pose[0] += x
    pose[1] += y
    pose[2] += yaw


@compiled
def direction(pose_a: Array, pose_b: Array) -> float:
    """Return the heading of the link [rad], C (10), O (1), with the quadrant that their atan leaves open."""
    return math.atan2(pose_a[1] - pose_b[1], pose_a[0] - pose_b[0])


@compiled
def follow(pose_b: Array, pose_a: Array, length: float, heading: float) -> None:
    """Put truck b on the link of a length [m] and heading [rad] behind truck a, C (16), O (5), in place."""
    pose_b[0] = pose_a[0] - length * math.cos(heading)
    pose_b[1] = pose_a[1] - length * math.sin(heading)
