"""The roughness of a hall's floor, from how far ways end beside odometry, whatever the robots are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import minimize_scalar

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.segments import Segments
    from omnimate.vehicle.se2 import Array

SAMPLE = 200  # recordings from which it is learned
SMOOTHEST, ROUGHEST = 5e-5, 5e-3  # [m/sqrt(m)] between a steel plate and cobbles


def roughness_of(segments: Sequence[Segments], floors: Sequence[Array] | None = None) -> float:
    """Return the median of what single recordings say [m/sqrt(m)]; sick robots move it little.

    Args:
        segments: Of recordings, each with two ways or more; evenly spread ones of them are used.
        floors: What known places make of the residuals of each, `(3 S,)`; nothing by default.
    """
    chosen = range(0, len(segments), max(1, len(segments) // SAMPLE))
    left = [
        segments[number].residual.reshape(-1) - (0.0 if floors is None else floors[number])
        for number in chosen
    ]
    return float(
        np.median([_likeliest(segments[number], rest) for number, rest in zip(chosen, left, strict=True)])
    )


def _likeliest(segments: Segments, residual: Array) -> float:
    """Return the likeliest roughness of one recording, by restricted likelihood beside its robot."""
    jacobian = segments.jacobian.reshape(-1, 3)

    def surprise(log_roughness: float) -> float:
        factor = np.linalg.cholesky(segments.covariance(math.exp(log_roughness)))
        white = np.linalg.solve(factor, np.column_stack([residual, jacobian]))
        basis, triangle = np.linalg.qr(white[:, 1:])
        left = white[:, 0] - basis @ (basis.T @ white[:, 0])
        weights = np.log(np.diag(factor)).sum() + np.log(np.abs(np.diag(triangle))).sum()
        return float(weights + 0.5 * left @ left)

    bounds = math.log(SMOOTHEST), math.log(ROUGHEST)
    return math.exp(minimize_scalar(surprise, bounds=bounds, method="bounded", options={"xatol": 0.01}).x)
