"""The corner chain of the square without small angles, and its inversion.

A robot that trusts its odometry drives the square exactly, as it believes. Where it really ends is the dead
reckoning of the same wheel turns with its actual parameters: eight exact arcs, four legs and four corners.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from calib.apply import corrected_truck
from calib.errors import CalibrationError
from calib.umbmark import Correction
from vehicle.odometry import arc, integrate

if TYPE_CHECKING:
    from calib.return_errors import ReturnErrors
    from vehicle.parameters import Truck
    from vehicle.se2 import Array

_LARGEST_RETURN = 1.5  # sides of the square; a robot that ends farther off did not drive one
_LARGEST_LOG_FACTOR = math.log(1.5)  # beyond it the chain folds over itself and means nothing


def square_returns(believed: Truck, actual: Truck, side: float) -> Array:
    """Return the return errors `(2, 3)` of a square, cw then ccw: x, y [m], theta [rad].

    Args:
        believed: the parameters that its odometry has.
        actual: the parameters that it has.
        side: of the square [m].
    """
    corner = 0.25 * math.pi * believed.wheelbase  # travel of each wheel in a quarter turn on the spot
    scale_left = actual.wheel_diameter_left / believed.wheel_diameter_left
    scale_right = actual.wheel_diameter_right / believed.wheel_diameter_right
    ends = []
    for sign in (-1.0, 1.0):
        left = scale_left * np.tile([side, -sign * corner], 4)
        right = scale_right * np.tile([side, sign * corner], 4)
        end = integrate(arc(left, right, actual.wheelbase))[-1]
        ends.append(end - [0.0, 0.0, sign * 2.0 * math.pi])
    return np.stack(ends)


def solve_exact(errors: ReturnErrors, truck: Truck, sigma: Array | None = None) -> Correction:
    """Return the correction whose exact chain fits the two centres of gravity best.

    Args:
        errors: of the runs.
        truck: the nominal parameters, with which the odometry was calculated.
        sigma: (3,) standard deviations of one run's x, y [m] and theta [rad], for the weights; without it
            the headings are left out and all positions weigh the same.

    Raises:
        CalibrationError: no robot fits the errors.
    """
    used = 2 if sigma is None else 3
    runs = np.sqrt([[len(errors.cw)], [len(errors.ccw)]])
    weights = runs / (np.full(2, errors.side) if sigma is None else np.asarray(sigma, np.float64))
    measured = errors.centres[:, :used]
    if not np.isfinite(measured).all():
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")

    def residual(logs: Array) -> Array:
        actual = corrected_truck(truck, math.exp(logs[0]), math.exp(logs[1]))
        return np.ravel(weights * (square_returns(truck, actual, errors.side)[:, :used] - measured))

    bound = _LARGEST_LOG_FACTOR
    found = least_squares(
        residual, np.zeros(2), bounds=(-bound, bound), x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    lost = errors.e_max_syst > _LARGEST_RETURN * errors.side or np.abs(found.x).max() > 0.99 * bound
    if lost or not found.success:
        raise CalibrationError(
            errors.source,
            f"no wheelbase and diameters explain return errors of {1e3 * errors.e_max_syst:.0f} mm "
            f"on a square of {errors.side:g} m; check the units and the side",
        )
    return _correction(truck, math.exp(found.x[0]), math.exp(found.x[1]), errors.side)


def _correction(truck: Truck, e_b: float, e_d: float, side: float) -> Correction:
    actual = corrected_truck(truck, e_b, e_d)
    right = actual.wheel_diameter_right / truck.wheel_diameter_right
    left = actual.wheel_diameter_left / truck.wheel_diameter_left
    alpha = 0.5 * math.pi * (1.0 - 1.0 / e_b)
    return Correction("exact", alpha, side * (right - left) / actual.wheelbase, e_b, e_d)
