"""UMBmark without small angles: the return errors of a square, and the correction that explains them.

A robot that follows its odometry drives the square exactly by its nominal parameters. Its true end is the
dead reckoning of the same wheel turns with the actual parameters: eight exact arcs, four legs and four
corners.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.calib.apply import corrected_truck, factors_between
from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.printed import Correction
from omnimate.calib.umbmark.square import fit_factors, square_ends, weights_of

if TYPE_CHECKING:
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

ExactMethod = Literal["exact", "weighted"]

_MAX_RETURN_SIDES = 1.5  # [sides of the square] largest E_max,syst of a driven square (assumption)
_MAX_LOG_FACTOR = math.log(1.5)  # log of the largest E_b or E_d; beyond it the solution is not unique


def square_returns(believed: Truck, actual: Truck, side: float) -> Array:
    """Return the return errors `(2, 3)` of a square, cw then ccw: x, y [m], theta [rad].

    The odometry uses the parameters of `believed`, and drives squares of `side` [m] with those of `actual`.
    """
    factors = factors_between(believed, actual)
    return square_ends(believed, side, np.array([factors.c_left, factors.c_right, factors.e_b]))


def weights_of_centres(errors: ReturnErrors, method: ExactMethod) -> Array:
    """Return the weights `(2, 3)` of x, y and theta of both centres of gravity.

    "exact" leaves the headings out and weighs all positions equally; "weighted" weighs positions and headings
    by the scatter of the runs.

    Raises:
        CalibrationError: "weighted" lacks a heading, or each direction has only a single run.
    """
    if method == "exact":
        return np.outer(np.sqrt(errors.runs) / errors.side, [1.0, 1.0, 0.0])
    if not errors.has_headings:
        raise CalibrationError(errors.source, "headings are wanted, but some run has none")
    if errors.freedom == 0:
        raise CalibrationError(
            errors.source, "one run in each direction has no scatter to weigh it by: drive five"
        )
    return weights_of(errors.sigma, errors.runs, errors.side)


def solve_exact(errors: ReturnErrors, truck: Truck, method: ExactMethod = "exact") -> Correction:
    """Return the correction of the nominal truck whose exact chain fits the two centres of gravity best.

    `method` says how x, y and headings are weighed, see `weights_of_centres`.

    Raises:
        CalibrationError: No robot fits the errors, or a heading or the scatter is missing.
    """
    logs, converged = fit_factors(errors.centres, weights_of_centres(errors, method), truck, errors.side)
    far = errors.e_max_syst > _MAX_RETURN_SIDES * errors.side
    if far or not converged or np.abs(logs).max() > _MAX_LOG_FACTOR:
        raise CalibrationError(
            errors.source,
            f"no wheelbase and diameters explain return errors of {1e3 * errors.e_max_syst:.0f} mm "
            f"on a square of {errors.side:g} m; check the units and the side",
        )
    e_b, e_d = (math.exp(log) for log in logs)
    actual = corrected_truck(truck, e_b, e_d)
    factors = factors_between(truck, actual)
    alpha = 0.5 * math.pi * (1.0 - 1.0 / e_b)
    beta = errors.side * (factors.c_right - factors.c_left) / actual.wheelbase
    return Correction(method, alpha, beta, e_b, e_d)
