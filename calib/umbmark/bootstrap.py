"""The uncertainty of a calibration by a bootstrap: 10 000 experiments drawn from the measured runs.

Deviations from the centres of gravity, pooled over both directions, are drawn with replacement, and each
drawn experiment is calibrated. Few runs scatter less than many would; therefore the deviations are inflated
by sqrt(N / (N - 2)), and the percentiles are those of Student's t (Hesterberg's expanded percentile
interval).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.distributions import normal_probability, student_quantile
from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.return_errors import MIRROR
from omnimate.calib.umbmark.square import fit_factors, weights_of
from omnimate.calib.umbmark.uncertainty import CONFIDENCE, Uncertainty, between_limits, factors_at

if TYPE_CHECKING:
    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.return_errors import ReturnErrors
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

    Logs = tuple[float, float]

RESAMPLES = 10_000
MIN_RUNS = 3  # per direction; with two, intervals of 95 per cent cover the truth in 88 per cent (simulation)


def can_bootstrap(errors: ReturnErrors) -> bool:
    """Return whether each direction has enough runs to draw from."""
    return min(errors.runs) >= MIN_RUNS


@dataclass(frozen=True, slots=True)
class Bootstrap:
    """The factors of all drawn experiments, and their percentile intervals."""

    factors: Array  # E_b and E_d of each drawn experiment, `(B, 2)`
    uncertainty: Uncertainty  # percentile intervals of the factors


def bootstrap(calibration: Calibration, resamples: int = RESAMPLES, seed: int = 0) -> Bootstrap:
    """Return resampled factors and their percentile intervals; the same seed draws the same resamples.

    Raises:
        CalibrationError: A direction has fewer than three runs, too few to draw from.
    """
    experiment, correction = calibration.experiment, calibration.correction
    errors = experiment.errors
    if not can_bootstrap(errors):
        raise CalibrationError(
            errors.source, f"a bootstrap needs {MIN_RUNS} runs in each direction at least: drive five"
        )
    inflated = np.nan_to_num(errors.deviations) * math.sqrt(sum(errors.runs) / errors.freedom)
    chance = np.random.default_rng(seed)
    middle = np.nan_to_num(errors.centres)
    cw = middle[0] + _draw(chance, inflated, resamples, len(errors.cw)) * MIRROR
    ccw = middle[1] + _draw(chance, inflated, resamples, len(errors.ccw))
    start = (math.log(correction.e_b), math.log(correction.e_d))
    if correction.method == "weighted":
        factors = weighted_factors(experiment.truck, errors.side, cw, ccw, start)
    else:
        centres = np.stack([cw.mean(axis=1), ccw.mean(axis=1)], axis=1)
        factors = factors_at(experiment, correction.method, centres, start)
    tail = normal_probability(student_quantile(0.5 - 0.5 * CONFIDENCE, errors.freedom))
    low, high = np.quantile(factors, [tail, 1.0 - tail], axis=0)
    covariance = np.cov(factors.T)
    return Bootstrap(factors, between_limits(calibration, covariance, errors.freedom, CONFIDENCE, low, high))


def _draw(chance: np.random.Generator, deviations: Array, resamples: int, runs: int) -> Array:
    """Return `(resamples, runs, 3)` deviations drawn with replacement."""
    return deviations[chance.integers(0, len(deviations), (resamples, runs))]


def weighted_factors(truck: Truck, side: float, cw: Array, ccw: Array, start: Logs = (0.0, 0.0)) -> Array:
    """Return E_b, E_d `(B, 2)` of the weighted fit to B experiments of runs `(B, n, 3)` at once.

    The weights of each experiment come from the scatter of its runs; the fit begins at the logarithms
    `start`.
    """
    centres = np.stack([cw.mean(axis=1), ccw.mean(axis=1)], axis=1)
    squares = sum(((runs - runs.mean(axis=1, keepdims=True)) ** 2).sum(axis=1) for runs in (cw, ccw))
    variance = squares / (cw.shape[1] + ccw.shape[1] - 2)
    place = variance[:, :2].mean(axis=1)
    sigma = np.sqrt(np.stack([place, place, variance[:, 2]], axis=-1))
    weights = weights_of(sigma, (cw.shape[1], ccw.shape[1]), side)
    return np.asarray(np.exp(fit_factors(centres, weights, truck, side, start)[0]), np.float64)
