"""What fixes and movements are off by, given all the others, and what each noise explains of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from calib.chains import Chains
    from calib.filtering import Smoothed
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Residuals:
    """Auxiliary residuals of M fixes and movements.

    Attributes:
        chains: that they belong to.
        heading: (M,) of the body frames [rad].
        smoothed: residuals, and their derivatives with respect to P coordinates.
        change: (P,) of the coordinates since the chains were built.
        bound: (P, P) covariance of the coordinates, whose estimation makes residuals smaller.
    """

    chains: Chains
    heading: Array
    smoothed: Smoothed
    change: Array
    bound: Array

    def explained(self, number: int, variance: float, weights: Array) -> tuple[Array, Array]:
        """Return what one noise explains of the residuals, and what it should, each `(M,)`."""
        kinds = len(self.chains.process)
        if number < kinds:
            shape, auxiliary = self.chains.process[number] * variance, self.smoothed.step
            spread = self.smoothed.step_precision
        else:
            scattered = self.chains.scatter[number - kinds] * variance
            shape = turned(scattered / weights[:, np.newaxis, np.newaxis], self.heading)
            auxiliary, spread = self.smoothed.fix, self.smoothed.fix_precision
        residual = auxiliary[:, :, 0] + auxiliary[:, :, 1:] @ self.change
        found = np.einsum("ki,ki->k", residual, (shape @ residual[:, :, np.newaxis])[:, :, 0])
        slope = auxiliary[:, :, 1:]
        mixed = shape @ (spread - slope @ self.bound @ slope.transpose(0, 2, 1))
        return found, np.trace(mixed, axis1=1, axis2=2)

    def distances(self, variances: Array, weights: Array) -> Array:
        """Return the squared distance `(M,)` of each fix from what all others say, in its own covariance."""
        noise = turned(self.chains.noise(variances), self.heading)
        fix = self.smoothed.fix
        apart = np.linalg.inv(self.smoothed.fix_precision + 1e-12 * np.eye(3))
        away = apart @ (fix[:, :, :1] + fix[:, :, 1:] @ self.change[:, np.newaxis])
        spread = apart + noise * (1.0 - 1.0 / weights)[:, np.newaxis, np.newaxis]
        square = (away.transpose(0, 2, 1) @ np.linalg.solve(spread, away))[:, 0, 0]
        return np.asarray(np.maximum(square, 0.0), np.float64)


def turned(covariance: Array, angle: Array) -> Array:
    """Return covariances `(M, 3, 3)` of the world frame in frames turned by angles `(M,)` [rad]."""
    turn = np.zeros((len(angle), 3, 3))
    turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
    turn[:, 0, 1], turn[:, 1, 0] = np.sin(angle), -np.sin(angle)
    turn[:, 2, 2] = 1.0
    return np.asarray(turn @ covariance @ turn.transpose(0, 2, 1), np.float64)
