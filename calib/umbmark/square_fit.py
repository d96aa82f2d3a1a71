"""Gauss-Newton fit of the exact square to centres of gravity, for many experiments at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.umbmark.square import factor_scales, square_ends

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

_STEPS = 60
_DONE = 1e-10  # change of a logarithm after which a solution stands
_LARGEST_STEP = 0.1  # of a logarithm: 10 per cent


def fit_factors(
    centres: Array, weights: Array, truck: Truck, side: float, start: tuple[float, float] = (0.0, 0.0)
) -> tuple[Array, NDArray[np.bool_]]:
    """Return log E_b, log E_d `(..., 2)` whose exact squares fit best, and whether each has converged.

    Gauss-Newton with closed-form derivatives; a step that makes the fit worse is shortened.

    Args:
        centres: Centres of gravity x, y [m], theta [rad], cw then ccw, shape `(..., 2, 3)`.
        weights: Reciprocal standard deviations of the centres, shape `(..., 2, 3)`; 0 leaves a value out.
        truck: Parameters that the odometry used.
        side: Length of each side of the square [m].
        start: log E_b and log E_d at which the fit begins.
    """
    lead = np.broadcast_shapes(centres.shape, weights.shape)
    weights = np.broadcast_to(weights, lead)
    wanted = np.where(weights > 0.0, np.broadcast_to(centres, lead), 0.0)
    logs = np.zeros((*lead[:-2], 2)) + start
    damping = np.full((*lead[:-2], 1), 1e-9)
    residual, slopes = _residual(logs, wanted, weights, truck, side)
    step = np.full_like(logs, np.inf)
    for _ in range(_STEPS):
        step = _step(residual, slopes, damping)
        tried = logs + step
        new_residual, new_slopes = _residual(tried, wanted, weights, truck, side)
        better = ((new_residual**2).sum(-1) <= (residual**2).sum(-1) * (1.0 + 1e-12))[..., None]
        logs = np.where(better, tried, logs)
        residual = np.where(better, new_residual, residual)
        slopes = np.where(better[..., None], new_slopes, slopes)
        damping = np.where(better, np.maximum(0.1 * damping, 1e-12), 10.0 * np.maximum(damping, 1e-6))
        if (np.abs(step) < _DONE).all():
            break
    return logs, np.asarray((np.abs(step) < 1e-6).all(axis=-1))


def _residual(logs: Array, wanted: Array, weights: Array, truck: Truck, side: float) -> tuple[Array, Array]:
    """Return the weighted residuals `(..., 6)` and their slopes `(..., 6, 2)`."""
    scales, by_logs = factor_scales(truck, logs)
    ends, by_scales = square_ends(truck, side, scales)
    slopes = weights[..., None] * (by_scales @ by_logs[..., None, :, :])
    lead = logs.shape[:-1]
    return (weights * (ends - wanted)).reshape(*lead, 6), slopes.reshape(*lead, 6, 2)


def _step(residual: Array, slopes: Array, damping: Array) -> Array:
    """Return the damped step `(..., 2)`, with the 2 x 2 equations solved by Cramer's rule."""
    normal = np.einsum("...ij,...ik->...jk", slopes, slopes)
    right = np.einsum("...ij,...i->...j", slopes, residual)
    a, d = (normal[..., k, k] * (1.0 + damping[..., 0]) for k in (0, 1))
    b = normal[..., 0, 1]
    determinant = a * d - b * b
    step = np.stack([b * right[..., 1] - d * right[..., 0], b * right[..., 0] - a * right[..., 1]], axis=-1)
    step = step / np.where(determinant > 0.0, determinant, 1.0)[..., None]
    return np.clip(step, -_LARGEST_STEP, _LARGEST_STEP)
