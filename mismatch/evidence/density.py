"""Log Bayes factors and predictive densities of linear models, from products of whitened columns.

Data are `y = X beta + e` with white noise of size one: the products X'X ("gram") and X'y ("score") suffice.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

# (standard deviation [declared sizes], weight) of the normal mixture of fault sizes
FAULT_SIZE_MIXTURE = ((1.0, 0.8), (5.0, 0.2))
MEMBER_SIZE = 5.0  # [declared sizes] prior standard deviation of a member of the set, integrated out
_SINGULARITY_MARGIN = 1e-9  # keeps the removal of a background invertible


def log_bayes_factor(gram: Array, score: Array) -> Array:
    """Return the log Bayes factor (...) of a fault against none, by products (..., k, k) and (..., k)."""
    parts = [math.log(share) + log_evidence(gram, score, size) for size, share in FAULT_SIZE_MIXTURE]
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


def without_background_prior(gram: Array, score: Array, sizes: Array) -> tuple[Array, Array]:
    """Return products (..., k, k) and (..., k) of columns for a robot without some background.

    Given are products with s background columns after them, whose coefficients have sizes `(..., s)`.
    """
    count = gram.shape[-1] - sizes.shape[-1]
    if gram.shape[-1] == count:
        return gram, score
    removal = _background_removal(gram[..., count:, count:], sizes)
    shared = sizes[..., None] * gram[..., count:, :count]
    scored = (removal @ (sizes * score[..., count:])[..., None])[..., 0]
    transposed = np.swapaxes(shared, -1, -2)
    return (
        gram[..., :count, :count] + transposed @ removal @ shared,
        score[..., :count] + (transposed @ scored[..., None])[..., 0],
    )


def background_log_bayes_factor(gram: Array, score: Array, sizes: Array, spread: float = 1.0) -> Array:
    """Return the log Bayes factor (...) of a background, which whitening took for noise, against none of it.

    Given are products (..., s, s) and (..., s) of its columns, coefficients' sizes, and an overdispersion.
    """
    if sizes.shape[-1] == 0:
        return np.zeros(gram.shape[:-2])
    removal = _background_removal(gram, sizes)
    scored = (removal @ (sizes * score)[..., None])[..., 0]
    return log_evidence((removal - np.eye(sizes.shape[-1])) / spread, scored / spread, 1.0)


def _background_removal(gram: Array, sizes: Array) -> Array:
    """Return the matrices (..., s, s) that take a background out of the noise."""
    information = sizes[..., :, None] * gram * sizes[..., None, :]
    return np.linalg.inv((1.0 + _SINGULARITY_MARGIN) * np.eye(sizes.shape[-1]) - information).astype(
        np.float64
    )


def heldout_log_density_gain(gram: Array, score: Array, spread: float) -> float:
    """Return the gain in log predictive density of folds held out in turn, by products (F, k, k) and (F, k).

    The noise is overdispersed by `spread`.
    """
    prior = np.eye(gram.shape[-1]) / MEMBER_SIZE**2
    others = (score.sum(axis=0) - score) / spread
    before = prior + (gram.sum(axis=0) - gram) / spread
    total, after = score.sum(axis=0) / spread, prior + gram.sum(axis=0) / spread
    known = (others * np.linalg.solve(before, others[..., None])[..., 0]).sum(axis=-1)
    gain = total @ np.linalg.solve(after, total) - np.linalg.slogdet(after)[1]
    return 0.5 * float((gain - known + np.linalg.slogdet(before)[1]).sum())
