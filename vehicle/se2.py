"""Poses in the plane: the group SE(2) on arrays whose last axis is x [m], y [m], theta [rad].

Every function takes one pose `(3,)` or many `(..., 3)`, broadcasts, and returns the same shape.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def wrap(angle: ArrayLike) -> Array:
    """Return the same angle [rad] in (-pi, pi]."""
    angle = np.asarray(angle, dtype=np.float64)
    return angle - 2.0 * np.pi * np.ceil((angle - np.pi) / (2.0 * np.pi))


def compose(first: ArrayLike, second: ArrayLike) -> Array:
    """Return the pose reached by going `second`, seen from `first`: first (+) second."""
    first, second = np.asarray(first, np.float64), np.asarray(second, np.float64)
    place = transform(first, second[..., :2])
    return np.concatenate([place, (first[..., 2] + second[..., 2])[..., np.newaxis]], axis=-1)


def inverse(pose: ArrayLike) -> Array:
    """Return the pose that undoes `pose`, so that composing the two gives zero."""
    pose = np.asarray(pose, np.float64)
    cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x = -cos * pose[..., 0] - sin * pose[..., 1]
    y = sin * pose[..., 0] - cos * pose[..., 1]
    return np.stack([x, y, -pose[..., 2]], axis=-1)


def between(first: ArrayLike, second: ArrayLike) -> Array:
    """Return `second` as seen from `first`: inverse(first) (+) second."""
    return compose(inverse(first), second)


def transform(pose: ArrayLike, point: ArrayLike) -> Array:
    """Return points `(..., 2)` [m], given in the frame of `pose`, in the frame that holds `pose`."""
    pose, point = np.asarray(pose, np.float64), np.asarray(point, np.float64)
    cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x = pose[..., 0] + cos * point[..., 0] - sin * point[..., 1]
    y = pose[..., 1] + sin * point[..., 0] + cos * point[..., 1]
    return np.stack([x, y], axis=-1)


def rotate(angle: ArrayLike, vector: ArrayLike) -> Array:
    """Return vectors `(..., 2)` turned counter-clockwise by angles `(...)` [rad]."""
    angle, vector = np.asarray(angle, np.float64), np.asarray(vector, np.float64)
    cos, sin = np.cos(angle), np.sin(angle)
    x = cos * vector[..., 0] - sin * vector[..., 1]
    y = sin * vector[..., 0] + cos * vector[..., 1]
    return np.stack([x, y], axis=-1)


def rotation(angle: ArrayLike) -> Array:
    """Return the matrices `(..., 3, 3)` that turn the world's x, y, theta into frames at angles [rad]."""
    angle = np.asarray(angle, np.float64)
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., 0, 0] = matrix[..., 1, 1] = np.cos(angle)
    matrix[..., 0, 1], matrix[..., 1, 0] = np.sin(angle), -np.sin(angle)
    matrix[..., 2, 2] = 1.0
    return matrix


def transport(increment: ArrayLike) -> Array:
    """Return how errors before increments `(..., 3)` become errors after them, `(..., 3, 3)`.

    It is the adjoint of the inverse. An error is in its own body frame: true pose = pose (+) error.
    """
    increment = np.asarray(increment, np.float64)
    matrix = rotation(increment[..., 2])
    matrix[..., :2, 2] = rotate(
        -increment[..., 2], np.stack([-increment[..., 1], increment[..., 0]], axis=-1)
    )
    return matrix
