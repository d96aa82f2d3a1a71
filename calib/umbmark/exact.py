"""UMBmark without small angles: the return errors of a square, and the correction that explains them.

A robot that follows its odometry drives the square exactly by its nominal parameters. Its true end is the
dead reckoning of the same wheel turns with the actual parameters: eight exact arcs, four legs and four
corners.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.printed import Correction
from omnimate.calib.umbmark.scatter import scatter_of, weights_of
from omnimate.calib.umbmark.square import fit_factors, square_ends

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

_MAX_RETURN_SIDES = 1.5  # [sides of the square] largest E_max,syst of a driven square (assumption)
_MAX_LOG_FACTOR = math.log(1.5)  # log of the largest E_b or E_d; beyond it the solution is not unique


def square_returns(believed: Truck, actual: Truck, side: float) -> Array:
    """Return the return errors `(2, 3)` of a square, cw then ccw: x, y [m], theta [rad].

    Args:
        believed: Parameters that the odometry uses.
        actual: True parameters of the truck.
        side: Length of each side of the square [m].
    """
    scales = np.array(
        [
            actual.wheel_diameter_left / believed.wheel_diameter_left,
            actual.wheel_diameter_right / believed.wheel_diameter_right,
            actual.wheelbase / believed.wheelbase,
        ]
    )
    return square_ends(believed, side, scales)[0]


def position_weights(errors: ReturnErrors) -> Array:
    """Return weights `(2, 3)` that leave the headings out and weigh all positions equally."""
    runs = np.sqrt([[len(errors.cw)], [len(errors.ccw)]])
    return np.asarray(runs / errors.side * [1.0, 1.0, 0.0], np.float64)


def scatter_weights(errors: ReturnErrors) -> Array:
    """Return weights `(2, 3)` of positions and headings from the scatter of the measured runs.

    Raises:
        CalibrationError: A heading is missing, or each direction has only a single run.
    """
    scatter = scatter_of(errors)
    if not errors.has_headings:
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")
    if scatter.freedom == 0:
        raise CalibrationError(
            errors.source, "one run in each direction has no scatter to weigh it by: drive five"
        )
    return weights_of(scatter.sigma, (len(errors.cw), len(errors.ccw)), errors.side)


def solve_exact(errors: ReturnErrors, truck: Truck, sigma: Array | None = None) -> Correction:
    """Return the correction whose exact chain fits the two centres of gravity best.

    Args:
        errors: Return errors of the runs.
        truck: Nominal parameters, with which the odometry was calculated.
        sigma: Standard deviations of x, y [m] and theta [rad] of one run for the weights, shape `(3,)`;
            without them the headings are left out and all positions weigh the same.

    Raises:
        CalibrationError: No robot fits the errors, or `sigma` is given and a heading is missing.
    """
    if sigma is None:
        return _solve(errors, truck, position_weights(errors), weighted=False)
    if not errors.has_headings:
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")
    weights = weights_of(np.asarray(sigma, np.float64), (len(errors.cw), len(errors.ccw)), errors.side)
    return _solve(errors, truck, weights, weighted=True)


def solve_weighted(errors: ReturnErrors, truck: Truck) -> Correction:
    """Return the correction that fits x, y and headings, each weighed by its scatter.

    Raises:
        CalibrationError: No robot fits the errors, a heading is missing, or the scatter is unknown.
    """
    return _solve(errors, truck, scatter_weights(errors), weighted=True)


def _solve(errors: ReturnErrors, truck: Truck, weights: Array, *, weighted: bool) -> Correction:
    logs, converged = fit_factors(errors.centres, weights, truck, errors.side)
    far = errors.e_max_syst > _MAX_RETURN_SIDES * errors.side
    if far or not converged or np.abs(logs).max() > _MAX_LOG_FACTOR:
        raise CalibrationError(
            errors.source,
            f"no wheelbase and diameters explain return errors of {1e3 * errors.e_max_syst:.0f} mm "
            f"on a square of {errors.side:g} m; check the units and the side",
        )
    e_b, e_d = (math.exp(log) for log in logs)
    actual = corrected_truck(truck, e_b, e_d)
    right = actual.wheel_diameter_right / truck.wheel_diameter_right
    left = actual.wheel_diameter_left / truck.wheel_diameter_left
    alpha, beta = 0.5 * math.pi * (1.0 - 1.0 / e_b), errors.side * (right - left) / actual.wheelbase
    return Correction("weighted" if weighted else "exact", alpha, beta, e_b, e_d)
