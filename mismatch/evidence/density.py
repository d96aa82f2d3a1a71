"""Densities of data with a candidate against those without it, from the products of its columns.

Rows are whitened, so that data are `y = X beta + e` with white noise of size one: the products of columns
with each other and with the data say everything.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

TAILS = ((1.0, 0.8), (5.0, 0.2))  # sizes of faults in declared ones, and how many faults are of them
LARGEST = 5.0  # declared sizes, one standard deviation of a member that is integrated out
_BELOW = 1e-9  # by which everyday sizes are less than all that is there


def bayes_factor(gram: Array, score: Array) -> Array:
    """Return the log Bayes factor (...) of a fault against none.

    Args:
        gram: Products of its columns with each other, shape `(..., k, k)`.
        score: Products of its columns with the data, shape `(..., k)`.
    """
    parts = [math.log(share) + log_evidence(gram, score, size) for size, share in TAILS]
    return np.asarray(np.logaddexp.reduce(parts, axis=0))


def log_evidence(gram: Array, score: Array, size: float) -> Array:
    """Return the log Bayes factor (...) of coefficients of a normal prior of a size against none."""
    precision = size**2 * gram + np.eye(gram.shape[-1])
    if gram.shape[-1] == 1:
        precision, score = precision[..., 0, 0], score[..., 0]
        return np.asarray(0.5 * size**2 * score**2 / precision - 0.5 * np.log(precision))
    solved = np.linalg.solve(precision, score[..., None])[..., 0]
    determinant = np.linalg.slogdet(precision)[1]
    return np.asarray(0.5 * size**2 * (score * solved).sum(axis=-1) - 0.5 * determinant)


def log_prior(coefficients: Array) -> Array:
    """Return the log prior density of coefficients, over that with which members are integrated out."""
    parts = [math.log(share / size) - 0.5 * (coefficients / size) ** 2 for size, share in TAILS]
    wide = -math.log(LARGEST) - 0.5 * (coefficients / LARGEST) ** 2
    return np.asarray(np.logaddexp.reduce(parts, axis=0) - wide)


def bared(gram: Array, score: Array, sizes: Array) -> tuple[Array, Array]:
    """Return products (..., k, k) and (..., k) of columns for a robot without any of some everyday sizes.

    Args:
        gram: Products of the columns and then the everyday ones, `(..., k + s, k + s)`.
        score: Their products with the data, `(..., k + s)`.
        sizes: Standard deviations of the everyday sizes, `(..., s)`.
    """
    count = gram.shape[-1] - sizes.shape[-1]
    if gram.shape[-1] == count:
        return gram, score
    away = _away(gram[..., count:, count:], sizes)
    shared = sizes[..., None] * gram[..., count:, :count]
    scored = (away @ (sizes * score[..., count:])[..., None])[..., 0]
    more = np.swapaxes(shared, -1, -2)
    return (
        gram[..., :count, :count] + more @ away @ shared,
        score[..., :count] + (more @ scored[..., None])[..., 0],
    )


def everyday_factor(gram: Array, score: Array, sizes: Array, spread: float = 1.0) -> Array:
    """Return the log Bayes factor (...) of everyday sizes that are noise to columns, against none of them.

    Args:
        gram: Products of the everyday columns, `(..., s, s)`.
        score: Their products with the data, `(..., s)`.
        sizes: Standard deviations of the everyday sizes, `(..., s)`.
        spread: Factor by which squares of noise are larger than they should be.
    """
    if sizes.shape[-1] == 0:
        return np.zeros(gram.shape[:-2])
    away = _away(gram, sizes)
    scored = (away @ (sizes * score)[..., None])[..., 0]
    return log_evidence((away - np.eye(sizes.shape[-1])) / spread, scored / spread, 1.0)


def _away(gram: Array, sizes: Array) -> Array:
    """Return the matrices (..., s, s) that take everyday sizes out of the noise."""
    inside = sizes[..., :, None] * gram * sizes[..., None, :]
    return np.linalg.inv((1.0 + _BELOW) * np.eye(sizes.shape[-1]) - inside).astype(np.float64)


def earned(gram: Array, score: Array, spread: float) -> float:
    """Return the gain in log predictive density of folds that are held out in turn.

    Args:
        gram: Products of columns with each other in each fold, `(F, k, k)`.
        score: Products with the data, `(F, k)`.
        spread: Factor by which squares of noise are larger than they should be.
    """
    prior = np.eye(gram.shape[-1]) / LARGEST**2
    others = (score.sum(axis=0) - score) / spread
    before = prior + (gram.sum(axis=0) - gram) / spread
    every, after = score.sum(axis=0) / spread, prior + gram.sum(axis=0) / spread
    known = (others * np.linalg.solve(before, others[..., None])[..., 0]).sum(axis=-1)
    gain = every @ np.linalg.solve(after, every) - np.linalg.slogdet(after)[1]
    return 0.5 * float((gain - known + np.linalg.slogdet(before)[1]).sum())
