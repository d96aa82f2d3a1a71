"""The uncertainty of a calibration: standard errors and confidence intervals, by the delta method.

The scatter of the runs, pooled over both directions, is multiplied by the derivatives of the method.
Intervals are those of Student's t; its degrees of freedom are the number of runs minus two centres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.distributions import student_quantile
from omnimate.calib.umbmark.exact import weights_of_centres
from omnimate.calib.umbmark.printed import angles_of, factors_of
from omnimate.calib.umbmark.square import fit_factors

if TYPE_CHECKING:
    from omnimate.calib.umbmark.experiment import Calibration, Experiment
    from omnimate.calib.umbmark.printed import Method
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

CONFIDENCE = 0.95  # probability that an interval contains the true value
_DERIVATIVE_STEP = 1e-5  # [sides of the square, rad] step of the numerical derivatives


@dataclass(frozen=True, slots=True)
class Interval:
    """An estimate with its confidence interval; the limits are nan where there are too few runs."""

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Half of the interval's width, for `value +- half`."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """The uncertainty of a calibration."""

    covariance: Array  # covariance of E_b and E_d, `(2, 2)`
    freedom: int  # degrees of freedom of the scatter
    confidence: float  # probability that an interval contains the true value
    e_b: Interval
    e_d: Interval
    wheelbase: Interval  # [m]
    diameter_left: Interval  # [m]
    diameter_right: Interval  # [m]


def uncertainty_of(calibration: Calibration, confidence: float = CONFIDENCE) -> Uncertainty:
    """Return standard errors and Student t intervals of a calibration by the delta method.

    With a single run in each direction they are nan, because the scatter of the runs is unknown.
    """
    experiment, method = calibration.experiment, calibration.correction.method
    errors = experiment.errors
    covariance = np.full((2, 2), np.nan)
    half = np.full(2, np.nan)
    if errors.freedom > 0:
        slopes = factor_slopes(experiment, method)
        used = slopes.any(axis=0)  # headings that no run has are not numbers
        covariance = slopes @ np.where(np.outer(used, used), errors.covariance_of_centres, 0.0) @ slopes.T
        half = student_quantile(0.5 + 0.5 * confidence, errors.freedom) * np.sqrt(np.diag(covariance))
    middle = np.array([calibration.correction.e_b, calibration.correction.e_d])
    return between_limits(calibration, covariance, errors.freedom, confidence, middle - half, middle + half)


def between_limits(
    calibration: Calibration, covariance: Array, freedom: int, confidence: float, low: Array, high: Array
) -> Uncertainty:
    """Return the uncertainty with limits `(2,)` of E_b and E_d; wheelbase and diameters follow from them.

    The printed equations assume small angles. Their bias, the difference to the exact solution of the same
    centres, is added to the limit on its side.
    """
    experiment, correction = calibration.experiment, calibration.correction
    truck = experiment.truck
    if correction.method.startswith("printed"):
        low, high = _with_bias(experiment, np.array([correction.e_b, correction.e_d]), low, high)
    least, most = _truck_or_none(truck, low), _truck_or_none(truck, high)

    def interval(name: str) -> Interval:
        ends = [math.nan if end is None else float(getattr(end, name)) for end in (least, most)]
        return Interval(getattr(calibration.truck, name), min(ends), max(ends))

    return Uncertainty(
        covariance,
        freedom,
        confidence,
        Interval(correction.e_b, float(low[0]), float(high[0])),
        Interval(correction.e_d, float(low[1]), float(high[1])),
        interval("wheelbase"),
        interval("wheel_diameter_left"),
        interval("wheel_diameter_right"),
    )


def _with_bias(experiment: Experiment, value: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return limits `(2,)` widened by the bias of the printed equations."""
    bias = factors_at(experiment, "exact", experiment.errors.centres) - value
    return low + np.minimum(bias, 0.0), high + np.maximum(bias, 0.0)


def _truck_or_none(truck: Truck, factors: Array) -> Truck | None:
    if not (np.isfinite(factors).all() and (factors > 0.0).all()):
        return None
    return corrected_truck(truck, float(factors[0]), float(factors[1]))


def factors_at(
    experiment: Experiment, method: Method, centres: Array, start: tuple[float, float] = (0.0, 0.0)
) -> Array:
    """Return E_b, E_d `(..., 2)` by a method from centres `(..., 2, 3)` in place of the measured ones.

    The weights of "weighted" stay those of the experiment.
    """
    errors, truck = experiment.errors, experiment.truck
    if method == "exact" or method == "weighted":  # noqa: PLR1714  # the type checker narrows this form only
        weights = weights_of_centres(errors, method)
        return np.exp(fit_factors(centres, weights, truck, errors.side, start)[0])
    return factors_of(angles_of(centres, errors.side, method), errors.side, truck.wheelbase, method)


def factor_slopes(experiment: Experiment, method: Method) -> Array:
    """Return the derivatives `(2, 6)` of E_b and E_d by the centres' x, y [m], theta [rad], cw then ccw."""
    errors = experiment.errors
    step = _DERIVATIVE_STEP * np.tile([errors.side, errors.side, 1.0], 2)
    centres = np.nan_to_num(errors.centres).reshape(6)
    moved = np.stack([centres + np.diag(step), centres - np.diag(step)]).reshape(2, 6, 2, 3)
    forward, backward = factors_at(experiment, method, moved)
    slopes = ((forward - backward) / (2.0 * step[:, None])).T
    return np.where(np.abs(slopes) < 1e-9 * np.abs(slopes).max(), 0.0, slopes)
