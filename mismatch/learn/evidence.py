"""Evidence of linear models with a normal prior, for many models and for every fold left out, at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array

# [1] relative to the largest expected square: smaller ones are rounding errors of a projection
MIN_RELATIVE_VARIANCE = 1e-9


@dataclass(frozen=True)
class Products:
    """Sufficient statistics of the rows of each of K folds for linear models of B columns."""

    gram: Array  # products of the columns with each other, shape `(K, B, B)`
    cross: Array  # products of the columns with the rows, shape `(K, B)`

    @classmethod
    def of(cls, columns: Array, rows: Array, folds: NDArray[np.int64]) -> Self:
        """Return the products of columns `(R, B)` and rows `(R,)`, given the fold of each row `(R,)`."""
        masks = [folds == fold for fold in np.unique(folds)]
        return cls(
            np.stack([columns[mask].T @ columns[mask] for mask in masks]),
            np.stack([columns[mask].T @ rows[mask] for mask in masks]),
        )

    def without(self, fold: int) -> Self:
        """Return the products of the other folds."""
        left = np.arange(len(self.cross)) != fold
        return type(self)(self.gram[left], self.cross[left])

    def scaled(self, level: float) -> Self:
        """Return the products of rows and columns that are divided by a noise level."""
        return type(self)(self.gram / level**2, self.cross / level**2)

    @cached_property
    def sums(self) -> tuple[Array, Array]:
        """Gram and cross products: of all folds, then without each."""
        gram, cross = self.gram.sum(axis=0), self.cross.sum(axis=0)
        return np.concatenate([gram[None], gram - self.gram]), np.concatenate(
            [cross[None], cross - self.cross]
        )

    def evidence(self, members: NDArray[np.int64], spread: Array, *, left_out: bool = True) -> Array:
        """Return the log evidence [nat] of P models against no model: with all folds, then without each.

        The log density of a fold's rows, predicted from all others, is the first minus that of the fold.
        `members` (P, w) are the models' columns, and `spread` (P, w) the prior standard deviations of their
        coefficients. It is of shape `(1 + K, P)`, or `(1, P)` if no fold is left out, for noise of unit
        variance.
        """
        gram, cross = self.sums if left_out else (total[:1] for total in self.sums)
        across = gram[:, members[:, :, None], members[:, None, :]]
        matrix, vector = _standard(across, cross[:, members], spread)
        root = np.linalg.cholesky(matrix + np.eye(members.shape[1]))
        fitted = np.linalg.solve(root, vector[..., None])[..., 0]
        width = np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
        return np.asarray(0.5 * (fitted**2).sum(axis=-1) - width)

    def posterior(self, members: NDArray[np.int64], spread: Array, training: int = 0) -> tuple[Array, Array]:
        """Return the coefficients `(w,)` of one model and their covariance `(w, w)`.

        `spread` (w,) has prior deviations; `training` is 0 for all folds, and k for all but fold k - 1.
        """
        gram, cross = (total[training] for total in self.sums)
        matrix, vector = _standard(gram[np.ix_(members, members)], cross[members], spread)
        covariance = np.linalg.inv(matrix + np.eye(len(members)))
        return spread * (covariance @ vector), spread[:, None] * covariance * spread

    def noise(self, members: NDArray[np.int64], spread: Array) -> float:
        """Return the root mean square of a model's errors in held-out folds, over the expected one.

        The errors are projected onto every column in turn, fold by fold, so that noise with the columns'
        autocorrelation counts with its effect on the coefficients. For white rows of unit size it is about 1.
        """
        errors, expected = [], []
        for fold in range(len(self.cross)):
            values, covariance = self.posterior(members, spread, 1 + fold)
            across = self.gram[fold][:, members]
            errors.append(self.cross[fold] - across @ values)
            noise = np.diagonal(self.gram[fold])
            expected.append(noise + np.einsum("bi,ij,bj->b", across, covariance, across))
        error, variance = np.array(errors), np.array(expected)
        known = variance > MIN_RELATIVE_VARIANCE * variance.max()  # not in a fold in which the robot stands
        return math.sqrt(np.mean(error[known] ** 2 / variance[known]))


def _standard(gram: Array, cross: Array, spread: Array) -> tuple[Array, Array]:
    """Return products of columns whose coefficients have a prior of unit size."""
    return spread[..., :, None] * gram * spread[..., None, :], spread * cross
