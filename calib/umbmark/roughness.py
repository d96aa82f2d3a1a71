"""The effect of a rough floor on odometry: covariances of the nonsystematic error in closed form.

Each wheel's travel scatters with a variance of k^2 for each metre that it rolls, independently of the other
wheel. Source: Chong & Kleeman, Accurate odometry and error modelling for a mobile robot, ICRA 1997.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import advance
from omnimate.vehicle.se2 import rotation

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.vehicle.se2 import Array

_STRAIGHT = 1e-5  # [rad] a smaller turn is a straight line to 1 part in 100 000


@dataclass(frozen=True, slots=True)
class Roughness:
    """The scatter of the travel of each wheel.

    Attributes:
        left: Standard deviation of the left wheel's travel after one metre [m/sqrt(m)].
        right: Standard deviation of the right wheel's travel after one metre [m/sqrt(m)].
    """

    left: float
    right: float


def arc_covariance(left: float, right: float, wheelbase: float, roughness: Roughness) -> Array:
    """Return the covariance `(3, 3)` of x, y [m], theta [rad] after an arc, in the frame of its start.

    A straight line (left = right), a turn on the spot (left = -right), or any arc between.

    Args:
        left: Travel of the left wheel [m].
        right: Travel of the right wheel [m].
        wheelbase: Wheelbase of the truck [m].
        roughness: Roughness of the floor under both wheels.
    """
    on_left, on_right = roughness.left**2 * abs(left), roughness.right**2 * abs(right)
    along = 0.25 * (on_left + on_right)  # variance of the centre's travel
    turning = (on_left + on_right) / wheelbase**2  # of the heading
    both = (on_right - on_left) / (2.0 * wheelbase)  # covariance of the two
    way, turn = 0.5 * (left + right), (right - left) / wheelbase
    moments = _straight(way) if abs(turn) < _STRAIGHT else _bent(way, turn)
    mixed = _products(moments.vw, moments.vw_conj)
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = (
        along * _products(moments.vv, 1.0)
        + turning * _products(moments.ww, moments.ww_conj)
        + both * (mixed + mixed.T)
    )
    lever = turning * moments.w + both * moments.v
    covariance[:2, 2] = covariance[2, :2] = lever.real, lever.imag
    covariance[2, 2] = turning
    return covariance


@dataclass(frozen=True, slots=True)
class _Moments:
    """Means along an arc, as x + i y: v is the direction of travel, w the shift of the end by a turn.

    `vw` is the mean of v w, `vw_conj` that of v with the conjugate of w, and so on.
    """

    v: complex
    w: complex
    vv: complex
    ww: complex
    ww_conj: complex
    vw: complex
    vw_conj: complex


def _straight(way: float) -> _Moments:
    return _Moments(1.0, 0.5j * way, 1.0, -(way**2) / 3.0, way**2 / 3.0, 0.5j * way, -0.5j * way)


def _bent(way: float, turn: float) -> _Moments:
    radius, end = way / turn, complex(math.cos(turn), math.sin(turn))
    once, twice = (end - 1.0) / (1j * turn), (end * end - 1.0) / (2j * turn)
    return _Moments(
        v=once,
        w=radius * (end - once),
        vv=twice,
        ww=radius**2 * (end * end - 2.0 * end * once + twice),
        ww_conj=radius**2 * (2.0 - 2.0 * (end * once.conjugate()).real),
        vw=radius * (end * once - twice),
        vw_conj=radius * (end.conjugate() * once - 1.0),
    )


def _products(plain: complex, conjugate: complex) -> Array:
    """Return the mean products `(2, 2)` of two vectors' components from the means of a b and a conj(b)."""
    total, rest = plain + conjugate, conjugate - plain
    return 0.5 * np.array([[total.real, -rest.imag], [total.imag, rest.real]])


def path_covariance(arcs: Iterable[tuple[float, float]], wheelbase: float, roughness: Roughness) -> Array:
    """Return the covariance `(3, 3)` after a path of arcs, in the frame of its start.

    Args:
        arcs: Travel of the left and of the right wheel [m] in each arc.
        wheelbase: Wheelbase of the truck [m].
        roughness: Roughness of the floor under both wheels.
    """
    covariance, heading = np.zeros((3, 3)), 0.0
    for left, right in arcs:
        x, y, after = advance((0.0, 0.0, heading), left, right, wheelbase)
        carry = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        aligned = rotation(heading)
        grown = aligned.T @ arc_covariance(left, right, wheelbase, roughness) @ aligned
        covariance = carry @ covariance @ carry.T + grown
        heading = after
    return covariance


def square_covariance(side: float, wheelbase: float, roughness: Roughness, sign: float = 1.0) -> Array:
    """Return the covariance `(3, 3)` of the return error of one square; `sign` +1 ccw, -1 cw."""
    corner = 0.25 * math.pi * wheelbase
    return path_covariance([(side, side), (-sign * corner, sign * corner)] * 4, wheelbase, roughness)
