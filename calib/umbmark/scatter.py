"""The scatter of the runs of one direction, with both directions pooled.

The square driven cw is the mirror image of the square driven ccw, and so is its scatter. Deviations of the cw
runs are mirrored (y and theta change sign) before both are pooled, which preserves correlations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.se2 import Array

MIRROR = np.array([1.0, -1.0, -1.0])  # signs of x, y, theta in the mirror image
_MIN_SIGMA = 1e-9  # [sides of the square, rad] smallest standard deviation, so that all weights are finite


@dataclass(frozen=True, slots=True)
class Scatter:
    """Deviations of single runs from the centre of gravity of their direction.

    Attributes:
        deviations: Deviations of all runs, those of cw mirrored: x, y [m], theta [rad] (nan where unknown),
            shape `(N, 3)`.
        freedom: Degrees of freedom: the number of runs minus two centres.
    """

    deviations: Array
    freedom: int

    @property
    def covariance(self) -> Array:
        """Covariance `(3, 3)` of one ccw run; nan without a degree of freedom or without headings."""
        if self.freedom == 0:
            return np.full((3, 3), np.nan)
        return np.asarray(self.deviations.T @ self.deviations / self.freedom, np.float64)

    @property
    def sigma(self) -> Array:
        """Standard deviations `(3,)` of one run's x, y (pooled, as in U section V) [m] and theta [rad]."""
        variance = np.diag(self.covariance).copy()
        variance[:2] = variance[:2].mean()
        return np.sqrt(variance)

    def of_centres(self, runs: tuple[int, int]) -> Array:
        """Return the covariance `(6, 6)` of the two centres of `runs` cw and ccw runs."""
        cw, ccw = np.outer(MIRROR, MIRROR) * self.covariance / runs[0], self.covariance / runs[1]
        both = np.zeros((6, 6))
        both[:3, :3], both[3:, 3:] = cw, ccw
        return both


def scatter_of(errors: ReturnErrors) -> Scatter:
    """Return the scatter of the runs; headings are used where every run has one."""
    parts = [errors.cw - errors.centres[0], errors.ccw - errors.centres[1]]
    deviations = np.concatenate([parts[0] * MIRROR, parts[1]])
    return Scatter(deviations, len(deviations) - 2)


def weights_of(sigma: Array, runs: tuple[int, int], side: float) -> Array:
    """Return the weights `(..., 2, 3)` of two centres whose single runs scatter by `sigma` `(..., 3)`."""
    smallest = _MIN_SIGMA * np.array([side, side, 1.0])
    counted = np.sqrt(np.array(runs, np.float64))[:, None]
    return np.asarray(counted / np.maximum(sigma, smallest)[..., None, :], np.float64)
