"""Exact circular arcs: the path of a truck whose wheels turn at constant speeds during one step.

A truck that travels an arc of length c and turns by an angle 2 h ends at a chord c sinc(h) along its mean
heading. The array functions serve whole recordings, `advance` one step of a
live stream, and `roll` one of compiled code.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.se2 import rotate, rotate_xy

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.se2 import Real

SMALL_ANGLE = 1e-6  # [rad] half angle below which sin(h)/h is 1 - h^2/6 to rounding
SMALL_SLOPE_ANGLE = 1e-4  # [rad] half angle below which (cos(h) - sin(h)/h) / h is -h/3 to rounding

PoseTuple = tuple[float, float, float]


def sinc(half: ArrayLike) -> Array:
    """Return sin(h)/h for angles h of any shape [rad]: an arc's chord over its length, h half its turn."""
    half = np.asarray(half, np.float64)
    small = np.abs(half) < SMALL_ANGLE
    ratio = np.sin(half) / np.where(small, 1.0, half)
    return np.asarray(np.where(small, 1.0 - half * half / 6.0, ratio), np.float64)


def sinc_of(half: float) -> float:
    """Return sin(h)/h for one angle h [rad]: `sinc` for plain floats and compiled code."""
    return 1.0 - half * half / 6.0 if abs(half) < SMALL_ANGLE else math.sin(half) / half


def sinc_slope(half: ArrayLike) -> Array:
    """Return the derivative of sin(h)/h by h for angles h of any shape [rad]."""
    half = np.asarray(half, np.float64)
    small = np.abs(half) < SMALL_SLOPE_ANGLE
    slope = (np.cos(half) - sinc(half)) / np.where(small, 1.0, half)
    return np.asarray(np.where(small, -half / 3.0, slope), np.float64)


def arc(left: ArrayLike, right: ArrayLike, wheelbase: ArrayLike) -> Array:
    """Return the pose increments `(..., 3)` of a truck, in its own frame, along exact circular arcs.

    `left` and `right` `(...)` are the travel of its wheels [m], `wheelbase` [m] is one or `(...)`.
    """
    left, right = np.asarray(left, np.float64), np.asarray(right, np.float64)
    turn = (right - left) / np.asarray(wheelbase, np.float64)
    half = 0.5 * turn
    chord = 0.5 * (left + right) * sinc(half)
    return np.stack([chord * np.cos(half), chord * np.sin(half), turn], axis=-1)


def arc_derivative(length: ArrayLike, turn: ArrayLike) -> Array:
    """Return the derivatives `(..., 3, 2)` of arcs by their length [m] and turn [rad], body frame after them.

    The chord has length `length` sinc(h), h = turn / 2, and points along the mean heading.
    """
    length, half = np.asarray(length, np.float64), 0.5 * np.asarray(turn, np.float64)
    ratio, slope = sinc(half), sinc_slope(half)
    cos, sin = np.cos(half), np.sin(half)
    along, across = 0.5 * length * slope, 0.5 * length * ratio
    by_length = np.stack([ratio * cos, -ratio * sin, np.zeros_like(half)], axis=-1)
    by_turn = np.stack([cos * along + sin * across, cos * across - sin * along, np.ones_like(half)], axis=-1)
    return np.stack([by_length, by_turn], axis=-1)


def arc_jacobian(left: ArrayLike, right: ArrayLike, wheelbase: ArrayLike) -> Array:
    """Return the derivatives `(..., 3, 3)` of `arc` by left, right and wheelbase, body frame after it."""
    left, right = np.asarray(left, np.float64), np.asarray(right, np.float64)
    base = np.asarray(wheelbase, np.float64)[..., np.newaxis]
    turn = (right - left)[..., np.newaxis] / base
    by_length, by_turn = np.moveaxis(arc_derivative(0.5 * (left + right), turn[..., 0]), -1, 0)
    by_left, by_right = 0.5 * by_length - by_turn / base, 0.5 * by_length + by_turn / base
    return np.stack([by_left, by_right, -turn / base * by_turn], axis=-1)


def travel_lever(heading: Real, x: Real, y: Real, turn: float) -> tuple[Real, Real]:
    """Return how much a later x and y change by a metre of a wheel's travel, in the frame of all poses.

    The travel moves the truck forward by half of it and turns it; compiled code calls this with floats.
    `heading` [rad] is that of the truck meanwhile, `x` and `y` [m] the displacement to the later pose, `turn`
    the turn by a metre of travel: -1 / wheelbase of the left wheel, 1 / wheelbase of the right [rad/m].
    """
    return 0.5 * np.cos(heading) - turn * y, 0.5 * np.sin(heading) + turn * x


def wheel_levers(heading: Array, displacement: Array, wheelbase: float) -> Array:
    """Return the derivatives `(..., 3, 2)` of later poses by the travel of the left and the right wheel.

    `heading` `(...)` [rad] is that of the truck meanwhile, `displacement` `(..., 2)` [m] that to the later
    pose.
    """
    columns = []
    for turn in (-1.0 / wheelbase, 1.0 / wheelbase):
        x, y = travel_lever(heading, displacement[..., 0], displacement[..., 1], turn)
        columns.append(np.stack([x, y, np.full_like(x, turn)], axis=-1))
    return np.stack(columns, axis=-1)


def integrate(increments: ArrayLike, start: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Return the poses `(N+1, 3)` that N increments `(N, 3)`, each in the frame before it, lead to."""
    increments, start = np.asarray(increments, np.float64), np.asarray(start, np.float64)
    heading = np.cumsum(np.concatenate(([start[2]], increments[:, 2])))
    x, y = np.moveaxis(rotate(heading[:-1], increments[:, :2]), -1, 0)
    x = np.cumsum(np.concatenate(([start[0]], x)))
    y = np.cumsum(np.concatenate(([start[1]], y)))
    return np.stack([x, y, heading], axis=-1)


def integrate_twists(twists: Array, heading: Array, start: Array) -> Array:
    """Return the poses `(N, 3)` along N - 1 arcs with sideways motion.

    Each twist goes forward and to the left [m], `(N - 1, 2)` or more columns; `heading` `(N,)` [rad] is that
    at the ends of the arcs. Of `start` `(3,)`, the first pose, x and y are used.
    """
    half = 0.5 * np.diff(heading)
    gone = rotate(heading[:-1] + half, twists[:, :2]) * sinc(half)[:, np.newaxis]
    place = np.concatenate((np.zeros((1, 2)), np.cumsum(gone, axis=0)))
    return np.column_stack([start[:2] + place, heading])


def twists_along(path: Array) -> Array:
    """Return the twists `(N - 1, ..., 3)` that lead along a path `(N, ..., 3)` on exact arcs.

    A twist is travel forward [m], travel to the left [m] and turn [rad]; `integrate_twists` undoes it.
    """
    yaw = np.diff(path[..., 2], axis=0)
    middle = path[:-1, ..., 2] + 0.5 * yaw
    gone = np.diff(path[..., :2], axis=0) / sinc(0.5 * yaw)[..., np.newaxis]
    return np.concatenate([rotate(-middle, gone), yaw[..., np.newaxis]], axis=-1)


def advance(pose: PoseTuple, left: float, right: float, wheelbase: float) -> PoseTuple:
    """Return the pose after one exact arc: `arc` and `integrate` for a single step of plain floats."""
    turn = (right - left) / wheelbase
    half = 0.5 * turn
    chord = 0.5 * (left + right) * sinc_of(half)
    x, y, theta = pose
    return x + chord * math.cos(theta + half), y + chord * math.sin(theta + half), theta + turn


@compiled
def roll(pose: Array, left: float, right: float, wheelbase: float) -> None:
    """Move a pose `(3,)` along the exact arc of its wheels' travel [m], in place."""
    pose[0], pose[1], pose[2] = advance((pose[0], pose[1], pose[2]), left, right, wheelbase)


@compiled
def glide(pose: Array, forward: float, left: float, yaw: float) -> None:
    """Move a pose `(3,)` forward and to the left [m] on the arc of its turn [rad], in place."""
    half = 0.5 * yaw
    chord = sinc_of(half)
    x, y = rotate_xy(pose[2] + half, chord * forward, chord * left)
    pose[0] += x
    pose[1] += y
    pose[2] += yaw
