"""The end of a square in closed form, and the fit of wheelbase and diameter ratio to measured ends.

One leg with its corner is one pose increment, z turned by phi; four of them end at z (1 + u + u^2 + u^3)
with u = exp(i phi), headed 4 phi. Leg and corner are exact arcs, U (2.5)-(2.15) without small angles.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.arcs import arc
from omnimate.vehicle.se2 import compose

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

SIGNS = np.array([-1.0, 1.0])  # cw, ccw
_DERIVATIVE_STEP = 1e-6  # of a logarithm: central differences are then exact to 1e-9 of the largest slope


def square_ends(truck: Truck, side: float, scales: Array) -> Array:
    """Return the ends `(..., 2, 3)` of squares of a side [m], cw then ccw.

    `scales` `(..., 3)` are actual left diameter, right diameter and wheelbase over those of `truck`, which
    the odometry uses.
    """
    left, right, base = (scales[..., None, column] for column in range(3))
    wheelbase = base * truck.wheelbase
    corner = 0.25 * math.pi * truck.wheelbase * SIGNS  # travel of the right wheel in a quarter turn
    step = compose(arc(left * side, right * side, wheelbase), arc(-left * corner, right * corner, wheelbase))
    turn = step[..., 2]
    place = (step[..., 0] + 1j * step[..., 1]) * np.exp(1j * turn[..., None] * np.arange(4)).sum(axis=-1)
    return np.stack([place.real, place.imag, 4.0 * turn - 2.0 * math.pi * SIGNS], axis=-1)


def factor_scales(truck: Truck, logs: Array) -> Array:
    """Return the scales `(..., 3)` of `square_ends` that log E_b, log E_d `(..., 2)` mean.

    The mean diameter is held, U (4.28), also if the nominal wheels are unequal.
    """
    e_b, e_d = np.exp(logs[..., 0]), np.exp(logs[..., 1])
    ratio = truck.wheel_diameter_right / truck.wheel_diameter_left
    left = (ratio + 1.0) / (e_d * ratio + 1.0)
    return np.stack([left, e_d * left, e_b], axis=-1)


def factor_ends(truck: Truck, side: float, logs: Array) -> tuple[Array, Array]:
    """Return the ends `(..., 2, 3)` of squares with log E_b, log E_d `(..., 2)`, and their slopes by these.

    The slopes have the shape `(..., 2, 3, 2)`.
    """
    step = _DERIVATIVE_STEP * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    ends = square_ends(truck, side, factor_scales(truck, logs[..., None, :] + step))
    slopes = (ends[..., 1::2, :, :] - ends[..., 2::2, :, :]) / (2.0 * _DERIVATIVE_STEP)
    return ends[..., 0, :, :], np.moveaxis(slopes, -3, -1)


_MIN_SIGMA = 1e-9  # [sides of the square, rad] smallest standard deviation, so that all weights are finite


def weights_of(sigma: Array, runs: tuple[int, int], side: float) -> Array:
    """Return the weights `(..., 2, 3)` of two centres whose single runs scatter by `sigma` `(..., 3)`."""
    smallest = _MIN_SIGMA * np.array([side, side, 1.0])
    counted = np.sqrt(np.array(runs, np.float64))[:, None]
    return np.asarray(counted / np.maximum(sigma, smallest)[..., None, :], np.float64)


_MAX_STEPS = 60
_CONVERGED = 1e-10  # change of a logarithm at convergence
_MAX_STEP = 0.1  # of a logarithm: 10 per cent


def fit_factors(
    centres: Array, weights: Array, truck: Truck, side: float, start: tuple[float, float] = (0.0, 0.0)
) -> tuple[Array, NDArray[np.bool_]]:
    """Return log E_b, log E_d `(..., 2)` whose exact squares fit best, and whether each has converged.

    Gauss-Newton from `start`; a step that makes the fit worse is shortened. The
    centres of gravity, x, y [m] and theta [rad], cw then ccw, and their weights, reciprocal standard
    deviations, have the shape `(..., 2, 3)`; a weight of 0 leaves a value out. `truck` has the parameters
    that the odometry used on squares of `side` [m].
    """
    lead = np.broadcast_shapes(centres.shape, weights.shape)
    weights = np.broadcast_to(weights, lead)
    wanted = np.where(weights > 0.0, np.broadcast_to(centres, lead), 0.0)
    logs = np.zeros((*lead[:-2], 2)) + start
    damping = np.full((*lead[:-2], 1), 1e-9)
    residual, slopes = _residual(logs, wanted, weights, truck, side)
    step = np.full_like(logs, np.inf)
    for _ in range(_MAX_STEPS):
        step = _step(residual, slopes, damping)
        tried = logs + step
        new_residual, new_slopes = _residual(tried, wanted, weights, truck, side)
        better = ((new_residual**2).sum(-1) <= (residual**2).sum(-1) * (1.0 + 1e-12))[..., None]
        logs = np.where(better, tried, logs)
        residual = np.where(better, new_residual, residual)
        slopes = np.where(better[..., None], new_slopes, slopes)
        damping = np.where(better, np.maximum(0.1 * damping, 1e-12), 10.0 * np.maximum(damping, 1e-6))
        if (np.abs(step) < _CONVERGED).all():
            break
    return logs, np.asarray((np.abs(step) < 1e-6).all(axis=-1))


def _residual(logs: Array, wanted: Array, weights: Array, truck: Truck, side: float) -> tuple[Array, Array]:
    """Return the weighted residuals `(..., 6)` and their slopes `(..., 6, 2)`."""
    ends, slopes = factor_ends(truck, side, logs)
    lead = logs.shape[:-1]
    return (weights * (ends - wanted)).reshape(*lead, 6), (weights[..., None] * slopes).reshape(*lead, 6, 2)


def _step(residual: Array, slopes: Array, damping: Array) -> Array:
    """Return the damped step `(..., 2)`, with the 2 x 2 equations solved by Cramer's rule."""
    normal = np.einsum("...ij,...ik->...jk", slopes, slopes)
    right = np.einsum("...ij,...i->...j", slopes, residual)
    a, d = (normal[..., k, k] * (1.0 + damping[..., 0]) for k in (0, 1))
    b = normal[..., 0, 1]
    determinant = a * d - b * b
    step = np.stack([b * right[..., 1] - d * right[..., 0], b * right[..., 0] - a * right[..., 1]], axis=-1)
    step = step / np.where(determinant > 0.0, determinant, 1.0)[..., None]
    return np.clip(step, -_MAX_STEP, _MAX_STEP)
