"""Auxiliary residuals: how far each fix and movement differs from all others, and which noise explains it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.distributions import chi2_upper_limit
from omnimate.vehicle.se2 import rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.calib.estimation.chains import Chains
    from omnimate.calib.estimation.filtering import Smoothed
    from omnimate.vehicle.se2 import Array

_OUTLIER_CHANCE = 1e-3  # probability that a good fix lies beyond the threshold
# By number of known components.
_THRESHOLD = np.concatenate(([np.inf], chi2_upper_limit(_OUTLIER_CHANCE, [1, 2, 3])))


@dataclass(frozen=True, slots=True)
class Residuals:
    """Auxiliary residuals of M fixes and movements."""

    chains: Chains  # the chains of fixes and movements
    heading: Array  # heading of each body frame [rad], `(M,)`
    smoothed: Smoothed  # the residuals and their derivatives by P coordinates
    change: Array  # change of the coordinates since the chains were built, `(P,)`
    bound: Array  # covariance of the coordinates, whose estimation makes residuals smaller, `(P, P)`

    def explained(self, number: int, variance: float, weights: Array) -> tuple[Array, Array]:
        """Return what a source of noise explains of the residuals, and its expectation, each `(M,)`.

        Both count a fix by its weight, and a movement by the smaller weight of its two fixes, so that
        outliers do not pass for noise of the others.
        """
        kinds = len(self.chains.process)
        if number < kinds:
            shape, auxiliary = self.chains.process[number] * variance, self.smoothed.step
            spread = self.smoothed.step_precision
            weights = np.minimum(weights, np.concatenate((weights[:1], weights[:-1])))
        else:
            shape = rotate_covariance(self.chains.scatter[number - kinds] * variance, self.heading)
            auxiliary, spread = self.smoothed.fix, self.smoothed.fix_precision
        residual = auxiliary[:, :, 0] + auxiliary[:, :, 1:] @ self.change
        explained = np.einsum("ki,ki->k", residual, (shape @ residual[:, :, np.newaxis])[:, :, 0])
        slope = auxiliary[:, :, 1:]
        mixed = shape @ (spread - slope @ self.bound @ slope.transpose(0, 2, 1))
        return explained * weights, np.trace(mixed, axis1=1, axis2=2) * weights

    def distances(self, variances: Array, weights: Array) -> Array:
        """Return the squared Mahalanobis distance `(M,)` of each fix from the prediction by all others."""
        noise = rotate_covariance(self.chains.noise(variances), self.heading)
        fix = self.smoothed.fix
        apart = np.linalg.inv(self.smoothed.fix_precision + 1e-12 * np.eye(3))
        away = apart @ (fix[:, :, :1] + fix[:, :, 1:] @ self.change[:, np.newaxis])
        spread = apart + noise * (1.0 - 1.0 / weights)[:, np.newaxis, np.newaxis]
        square = (away.transpose(0, 2, 1) @ np.linalg.solve(spread, away))[:, 0, 0]
        return np.asarray(np.maximum(square, 0.0), np.float64)


def outlier_weights(square: Array, components: NDArray[np.int_]) -> Array:
    """Return the weights `(M,)` of fixes by their squared distances `(M,)`; 1 within the limit."""
    return np.asarray(np.minimum(1.0, _THRESHOLD[components] / np.maximum(square, 1e-12)), np.float64)


def rotate_covariance(covariance: Array, angle: Array) -> Array:
    """Return covariances `(M, 3, 3)` of the world frame in frames turned by angles `(M,)` [rad]."""
    turn = rotation(angle)
    return np.asarray(turn @ covariance @ turn.transpose(0, 2, 1), np.float64)
