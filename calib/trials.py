"""UMBmark many times over, without a plant: exact squares whose runs scatter with a known covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.apply import corrected_truck
from calib.bootstrap import weighted_factors
from calib.bound import factor_bound
from calib.chain import square_returns
from calib.experiment import Experiment, calibrate
from calib.fit import fit_factors
from calib.return_errors import ReturnErrors
from calib.roughness import Roughness, square_covariance
from calib.scatter import MIRROR, weights_of
from calib.uncertainty import uncertainty_of
from vehicle.parameters import Truck

if TYPE_CHECKING:
    from calib.umbmark import Method
    from vehicle.se2 import Array

LABMATE = Truck(wheelbase=0.340, wheel_diameter_left=0.150, wheel_diameter_right=0.150)  # U V
HEADING = math.radians(0.55)  # of a floor that scatters the position by 25 mm


def plain_covariance(position: float, heading: float = HEADING) -> Array:
    """Return the covariance `(3, 3)` of independent x, y [m] and theta [rad]."""
    return np.diag([position**2, position**2, heading**2])


def floor_covariance(position: float, truck: Truck = LABMATE, side: float = 4.0) -> Array:
    """Return the covariance `(3, 3)` on a floor so rough that x and y scatter by `position` [m]."""
    unit = square_covariance(side, truck.wheelbase, Roughness(1.0, 1.0))
    return np.asarray(unit * (position**2 / unit[0, 0]), np.float64)


@dataclass(frozen=True, slots=True)
class Trial:
    """A robot, its square, and the scatter of its runs.

    Attributes:
        e_b: its true wheelbase factor.
        e_d: its true factor of the ratio of diameters.
        covariance: (3, 3) of one ccw run's return error.
        runs: in each direction.
        truck: nominal.
        side: of the square [m].
    """

    e_b: float
    e_d: float
    covariance: Array
    runs: int = 5
    truck: Truck = LABMATE
    side: float = 4.0

    @property
    def actual(self) -> Truck:
        """The truck as it is."""
        return corrected_truck(self.truck, self.e_b, self.e_d)

    def runs_of(
        self, chance: np.random.Generator, direction: int, count: int, believed: Truck | None = None
    ) -> Array:
        """Return the return errors `(count, runs, 3)` of so many experiments: 0 cw, 1 ccw."""
        end = square_returns(believed or self.truck, self.actual, self.side)[direction]
        noise = chance.multivariate_normal(
            np.zeros(3), self.covariance, (count, self.runs), method="cholesky"
        )
        return np.asarray(end + noise * (MIRROR if direction == 0 else 1.0), np.float64)

    def drive(self, chance: np.random.Generator, believed: Truck | None = None) -> Experiment:
        """Return an experiment of a robot that believes in `believed`, or in the nominal truck."""
        cw, ccw = (self.runs_of(chance, direction, 1, believed)[0] for direction in (0, 1))
        return Experiment("trial", believed or self.truck, ReturnErrors(cw, ccw, self.side, "trial"))


def after_calibration(trial: Trial, count: int, method: Method = "printed", seed: int = 0) -> Array:
    """Return E_max,syst [m] `(count,)` of robots calibrated once and driven again, as in U Table I."""
    chance = np.random.default_rng(seed)
    found = (calibrate(trial.drive(chance), method).truck for _ in range(count))
    return np.array([trial.drive(chance, truck).errors.e_max_syst for truck in found])


def left_over(trial: Trial, count: int, method: Method, seed: int = 0) -> Array:
    """Return E_max,syst [m] `(count,)` that robots calibrated once would have without any scatter."""
    chance = np.random.default_rng(seed)
    sizes = []
    for _ in range(count):
        found = calibrate(trial.drive(chance), method).truck
        ends = square_returns(found, trial.actual, trial.side)
        sizes.append(float(np.hypot(ends[:, 0], ends[:, 1]).max()))
    return np.array(sizes)


def efficiency(trial: Trial, count: int, *, own_scatter: bool = True, seed: int = 0) -> Array:
    """Return the mean square errors of E_b and E_d `(2,)` of the weighted fit over their Cramer-Rao bounds.

    Args:
        trial: what is driven.
        count: how often.
        own_scatter: weigh by the scatter of the runs themselves, as on a robot, or by the true one.
        seed: of the scatter.
    """
    chance = np.random.default_rng(seed)
    cw, ccw = (trial.runs_of(chance, direction, count) for direction in (0, 1))
    if own_scatter:
        factors = weighted_factors(trial.truck, trial.side, cw, ccw)
    else:
        weights = weights_of(np.sqrt(np.diag(trial.covariance)), (trial.runs, trial.runs), trial.side)
        centres = np.stack([cw.mean(axis=1), ccw.mean(axis=1)], axis=1)
        factors = np.exp(fit_factors(centres, weights, trial.truck, trial.side)[0])
    square = np.mean((factors - [trial.e_b, trial.e_d]) ** 2, axis=0)
    runs = (trial.runs, trial.runs)
    bound = factor_bound(trial.truck, (trial.e_b, trial.e_d), trial.side, runs, trial.covariance)
    return np.asarray(square / np.diag(bound), np.float64)


def coverage(trial: Trial, count: int, method: Method, confidence: float = 0.95, seed: int = 0) -> Array:
    """Return how often the delta method's intervals of E_b and E_d `(2,)` hold the truth."""
    chance = np.random.default_rng(seed)
    held = []
    for _ in range(count):
        one = uncertainty_of(calibrate(trial.drive(chance), method), confidence)
        held.append((one.e_b.low <= trial.e_b <= one.e_b.high, one.e_d.low <= trial.e_d <= one.e_d.high))
    return np.asarray(np.mean(held, axis=0), np.float64)
