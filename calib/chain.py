"""The corner chain of the square without small angles, and its inversion.

A robot that trusts its odometry drives the square exactly, as it believes. Where it really ends is the dead
reckoning of the same wheel turns with its actual parameters: eight exact arcs, four legs and four corners.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from calib.apply import corrected_truck
from calib.errors import CalibrationError
from calib.fit import fit_factors
from calib.scatter import scatter_of, weights_of
from calib.square import square_ends
from calib.umbmark import Correction

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
    scales = np.array(
        [
            actual.wheel_diameter_left / believed.wheel_diameter_left,
            actual.wheel_diameter_right / believed.wheel_diameter_right,
            actual.wheelbase / believed.wheelbase,
        ]
    )
    return square_ends(believed, side, scales)[0]


def position_weights(errors: ReturnErrors) -> Array:
    """Return weights `(2, 3)` that leave the headings out and weigh all positions the same."""
    runs = np.sqrt([[len(errors.cw)], [len(errors.ccw)]])
    return np.asarray(runs / errors.side * [1.0, 1.0, 0.0], np.float64)


def own_weights(errors: ReturnErrors) -> Array:
    """Return weights `(2, 3)` of positions and headings from the scatter of the runs themselves.

    Raises:
        CalibrationError: a heading is missing, or there is one run in each direction only.
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
        errors: of the runs.
        truck: the nominal parameters, with which the odometry was calculated.
        sigma: (3,) standard deviations of one run's x, y [m] and theta [rad], for the weights; without it
            the headings are left out and all positions weigh the same.

    Raises:
        CalibrationError: no robot fits the errors, or headings are wanted and missing.
    """
    if sigma is None:
        return _solve(errors, truck, position_weights(errors), weighted=False)
    if not errors.has_headings:
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")
    weights = weights_of(np.asarray(sigma, np.float64), (len(errors.cw), len(errors.ccw)), errors.side)
    return _solve(errors, truck, weights, weighted=True)


def solve_weighted(errors: ReturnErrors, truck: Truck) -> Correction:
    """Return the correction that fits x, y and headings, each weighed by its own scatter.

    Raises:
        CalibrationError: no robot fits the errors, a heading is missing, or the scatter is unknown.
    """
    return _solve(errors, truck, own_weights(errors), weighted=True)


def _solve(errors: ReturnErrors, truck: Truck, weights: Array, *, weighted: bool) -> Correction:
    logs, converged = fit_factors(errors.centres, weights, truck, errors.side)
    far = errors.e_max_syst > _LARGEST_RETURN * errors.side
    if far or not converged or np.abs(logs).max() > _LARGEST_LOG_FACTOR:
        raise CalibrationError(
            errors.source,
            f"no wheelbase and diameters explain return errors of {1e3 * errors.e_max_syst:.0f} mm "
            f"on a square of {errors.side:g} m; check the units and the side",
        )
    e_b, e_d = (math.exp(one) for one in logs)
    actual = corrected_truck(truck, e_b, e_d)
    right = actual.wheel_diameter_right / truck.wheel_diameter_right
    left = actual.wheel_diameter_left / truck.wheel_diameter_left
    alpha, beta = 0.5 * math.pi * (1.0 - 1.0 / e_b), errors.side * (right - left) / actual.wheelbase
    return Correction("weighted" if weighted else "exact", alpha, beta, e_b, e_d)
