"""How well a calibration is known: standard errors and confidence intervals, by the delta method.

The scatter of the runs, pooled over both directions, is carried through the method's own derivatives.
Intervals are Student's t with as many degrees of freedom as there are runs less two centres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import t as student

from calib.apply import corrected_truck
from calib.chain import own_weights, position_weights
from calib.fit import fit_factors
from calib.scatter import scatter_of
from calib.umbmark import angles_of, factors_of

if TYPE_CHECKING:
    from calib.experiment import Calibration, Experiment
    from calib.umbmark import Method
    from vehicle.parameters import Truck
    from vehicle.se2 import Array

_NUDGE = 1e-5  # of the side, or [rad]: step of the derivatives


@dataclass(frozen=True, slots=True)
class Interval:
    """A value that lies between two limits with the confidence asked for; nan where n is too small.

    Attributes:
        value: the estimate.
        low: lower limit.
        high: upper limit.
    """

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """Half of its width, for `value +- half`."""
        return 0.5 * (self.high - self.low)


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """What is known about a calibration.

    Attributes:
        covariance: (2, 2) of E_b and E_d.
        freedom: degrees of freedom of the scatter that it rests on.
        confidence: of the intervals.
        e_b: interval of E_b; so on.
    """

    covariance: Array
    freedom: int
    confidence: float
    e_b: Interval
    e_d: Interval
    wheelbase: Interval
    diameter_left: Interval
    diameter_right: Interval


def uncertainty_of(calibration: Calibration, confidence: float = 0.95) -> Uncertainty:
    """Return standard errors and Student t intervals of a calibration by the delta method.

    With one run in each direction they are nan: nothing says how much the runs scatter.
    """
    experiment, method = calibration.experiment, calibration.correction.method
    errors = experiment.errors
    scatter = scatter_of(errors)
    covariance = np.full((2, 2), np.nan)
    half = np.full(2, np.nan)
    if scatter.freedom > 0:
        slopes = factor_slopes(experiment, method)
        centres = scatter.of_centres((len(errors.cw), len(errors.ccw)))
        used = slopes.any(axis=0)  # headings that no run has are not numbers
        covariance = slopes @ np.where(np.outer(used, used), centres, 0.0) @ slopes.T
        half = student.ppf(0.5 + 0.5 * confidence, scatter.freedom) * np.sqrt(np.diag(covariance))
    middle = np.array([calibration.correction.e_b, calibration.correction.e_d])
    return between_limits(calibration, covariance, scatter.freedom, confidence, middle - half, middle + half)


def between_limits(
    calibration: Calibration, covariance: Array, freedom: int, confidence: float, low: Array, high: Array
) -> Uncertainty:
    """Return the uncertainty that limits `(2,)` of E_b and E_d mean; wheelbase and diameters follow them."""
    truck, found = calibration.experiment.truck, calibration.truck
    least, most = _truck_or_none(truck, low), _truck_or_none(truck, high)

    def interval(name: str) -> Interval:
        ends = [math.nan if one is None else float(getattr(one, name)) for one in (least, most)]
        return Interval(getattr(found, name), min(ends), max(ends))

    correction = calibration.correction
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


def _truck_or_none(truck: Truck, factors: Array) -> Truck | None:
    if not (np.isfinite(factors).all() and (factors > 0.0).all()):
        return None
    return corrected_truck(truck, float(factors[0]), float(factors[1]))


def factors_at(
    experiment: Experiment, method: Method, centres: Array, start: tuple[float, float] = (0.0, 0.0)
) -> Array:
    """Return E_b, E_d `(..., 2)` that a method makes of centres `(..., 2, 3)` in place of the measured ones.

    The weights of "weighted" stay those of the experiment.
    """
    errors, truck = experiment.errors, experiment.truck
    if method in {"exact", "weighted"}:
        weights = position_weights(errors) if method == "exact" else own_weights(errors)
        return np.exp(fit_factors(centres, weights, truck, errors.side, start)[0])
    return factors_of(angles_of(centres, errors.side, method), errors.side, truck.wheelbase, method)


def factor_slopes(experiment: Experiment, method: Method) -> Array:
    """Return the derivatives `(2, 6)` of E_b and E_d by the centres' x, y [m], theta [rad], cw then ccw."""
    errors = experiment.errors
    step = _NUDGE * np.tile([errors.side, errors.side, 1.0], 2)
    centres = np.nan_to_num(errors.centres).reshape(6)
    moved = np.stack([centres + np.diag(step), centres - np.diag(step)]).reshape(2, 6, 2, 3)
    forward, backward = factors_at(experiment, method, moved)
    slopes = ((forward - backward) / (2.0 * step[:, None])).T
    return np.where(np.abs(slopes) < 1e-9 * np.abs(slopes).max(), 0.0, slopes)
