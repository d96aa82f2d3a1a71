"""Poses in the plane: the group SE(2) on x [m], y [m], theta [rad].

A function of arrays takes one pose `(3,)` or many `(..., 3)`, broadcasts, and returns the same shape. Those
with `_xy` take components, arrays or the floats of compiled code. Compiled functions work on one pose `(3,)`
and write into existing arrays, because allocation costs more than the arithmetic.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from omnimate.vehicle.compiled import Array as Array  # noqa: PLC0414 -- named with the poses, too
from omnimate.vehicle.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Real = TypeVar("Real", float, Array)


def rotate_xy(angle: Real, x: Real, y: Real) -> tuple[Real, Real]:
    """Return a vector [m] turned counter-clockwise by an angle [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cos * x - sin * y, sin * x + cos * y


def wrap(angle: ArrayLike) -> Array:
    """Return the same angle [rad] in (-pi, pi]."""
    angle = np.asarray(angle, dtype=np.float64)
    return angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))


def compose(first: ArrayLike, second: ArrayLike) -> Array:
    """Return the composition first (+) second: `second` is given in the frame of `first`."""
    first, second = np.asarray(first, np.float64), np.asarray(second, np.float64)
    place = transform(first, second[..., :2])
    return np.concatenate([place, (first[..., 2] + second[..., 2])[..., np.newaxis]], axis=-1)


def inverse(pose: ArrayLike) -> Array:
    """Return the pose that undoes `pose`, so that composing the two gives zero."""
    pose = np.asarray(pose, np.float64)
    return np.stack([*rotate_xy(-pose[..., 2], -pose[..., 0], -pose[..., 1]), -pose[..., 2]], axis=-1)


def between(first: ArrayLike, second: ArrayLike) -> Array:
    """Return `second` as seen from `first`: inverse(first) (+) second."""
    return compose(inverse(first), second)


def transform(pose: ArrayLike, point: ArrayLike) -> Array:
    """Return points `(..., 2)` [m], given in the frame of `pose`, in the frame that holds `pose`."""
    pose = np.asarray(pose, np.float64)
    return np.asarray(pose[..., :2] + rotate(pose[..., 2], point), np.float64)


def rotate(angle: ArrayLike, vector: ArrayLike) -> Array:
    """Return vectors `(..., 2)` turned counter-clockwise by angles `(...)` [rad]."""
    angle, vector = np.asarray(angle, np.float64), np.asarray(vector, np.float64)
    return np.stack(rotate_xy(angle, vector[..., 0], vector[..., 1]), axis=-1)


def rotation(angle: ArrayLike) -> Array:
    """Return the matrices `(..., 3, 3)` that turn the world's x, y, theta into frames at angles [rad]."""
    angle = np.asarray(angle, np.float64)
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., 0, 0] = matrix[..., 1, 1] = np.cos(angle)
    matrix[..., 0, 1], matrix[..., 1, 0] = np.sin(angle), -np.sin(angle)
    matrix[..., 2, 2] = 1.0
    return matrix


def lever_matrix(displacement: ArrayLike) -> Array:
    """Return the derivatives `(..., 3, 3)` of a pose after a displacement `(..., 2)` [m], by x, y, theta."""
    displacement = np.asarray(displacement, np.float64)
    matrix = np.zeros((*displacement.shape[:-1], 3, 3))
    matrix[...] = np.eye(3)
    matrix[..., 0, 2], matrix[..., 1, 2] = -displacement[..., 1], displacement[..., 0]
    return matrix


def transport(increment: ArrayLike) -> Array:
    """Return the matrices `(..., 3, 3)` that propagate errors over increments `(..., 3)`.

    It is the adjoint of the inverse. An error is in its own body frame: true pose = pose (+) error.
    """
    increment = np.asarray(increment, np.float64)
    matrix = rotation(increment[..., 2])
    matrix[..., :2, 2] = rotate(
        -increment[..., 2], np.stack([-increment[..., 1], increment[..., 0]], axis=-1)
    )
    return matrix


@compiled
def wrap_angle(angle: float) -> float:
    """Return the same angle [rad] in [-pi, pi): `wrap`, whose interval is (-pi, pi], for compiled code."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def transform_xy(pose: Array, x: float, y: float) -> tuple[float, float]:
    """Return a point [m], given in the frame of a pose `(3,)`, in the frame that holds the pose."""
    turned_x, turned_y = rotate_xy(pose[2], x, y)
    return pose[0] + turned_x, pose[1] + turned_y


@compiled
def write_composed(out: Array, first: Array, second: Array) -> None:
    """Write first (+) second of two poses `(3,)`; `out` may be one of them."""
    x, y = transform_xy(first, second[0], second[1])
    out[2] = first[2] + second[2]
    out[0], out[1] = x, y


@compiled
def write_rotation(out: Array, angle: float) -> None:
    """Write the matrix `(3, 3)` of `rotation`."""
    cos, sin = math.cos(angle), math.sin(angle)
    out[:] = 0.0
    out[0, 0], out[0, 1] = cos, sin
    out[1, 0], out[1, 1] = -sin, cos
    out[2, 2] = 1.0


@compiled
def write_transport(out: Array, increment: Array) -> None:
    """Write the matrix `(3, 3)` of `transport`."""
    write_rotation(out, increment[2])
    out[0, 2], out[1, 2] = rotate_xy(-increment[2], -increment[1], increment[0])
