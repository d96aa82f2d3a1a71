"""UMBmark experiments by Monte Carlo: exact squares whose runs scatter with a known covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError
from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.calib.umbmark.bootstrap import weighted_factors
from omnimate.calib.umbmark.exact import square_returns
from omnimate.calib.umbmark.experiment import Experiment, calibrate
from omnimate.calib.umbmark.floor import square_covariance
from omnimate.calib.umbmark.printed import Method
from omnimate.calib.umbmark.return_errors import MIRROR, ReturnErrors
from omnimate.calib.umbmark.square import factor_ends, fit_factors, weights_of
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import Array

LABMATE = Truck(wheelbase=0.340, wheel_diameter_left=0.150, wheel_diameter_right=0.150)  # U V
SIDE = 4.0  # [m] of its square
HEADING = math.radians(0.55)  # [rad] scatter of the heading on a floor that scatters the position by 25 mm


def plain_covariance(position: float, heading: float = HEADING) -> Array:
    """Return the covariance `(3, 3)` of independent x, y [m] and theta [rad]."""
    return np.diag([position**2, position**2, heading**2])


def floor_covariance(position: float) -> Array:
    """Return the covariance `(3, 3)` on a floor so rough that x and y scatter by `position` [m]."""
    unit = square_covariance(SIDE, LABMATE.wheelbase)
    return np.asarray(unit * (position**2 / unit[0, 0]), np.float64)


@dataclass(frozen=True, slots=True)
class Trial:
    """A robot that is believed to be `LABMATE`, and the scatter of its runs."""

    e_b: float  # true factor of the wheelbase, U (2.4)
    e_d: float  # true factor of the ratio of wheel diameters, U (2.3)
    covariance: Array  # covariance of the return error x, y [m], theta [rad] of one ccw run, shape `(3, 3)`
    runs: int = 5  # number of runs in each direction

    @property
    def actual(self) -> Truck:
        """The truck as it is."""
        return corrected_truck(LABMATE, self.e_b, self.e_d)

    def runs_of(
        self, chance: np.random.Generator, direction: int, count: int, believed: Truck | None = None
    ) -> Array:
        """Return the return errors `(count, runs, 3)` of `count` experiments in a direction: 0 cw, 1 ccw."""
        end = square_returns(believed or LABMATE, self.actual, SIDE)[direction]
        noise = chance.multivariate_normal(
            np.zeros(3), self.covariance, (count, self.runs), method="cholesky"
        )
        return np.asarray(end + noise * (MIRROR if direction == 0 else 1.0), np.float64)

    def drive(self, chance: np.random.Generator, believed: Truck | None = None) -> Experiment:
        """Return an experiment of a robot whose odometry uses `believed`, or the nominal truck."""
        cw, ccw = (self.runs_of(chance, direction, 1, believed)[0] for direction in (0, 1))
        return Experiment("trial", believed or LABMATE, ReturnErrors(cw, ccw, SIDE, "trial"))


def after_calibration(trial: Trial, count: int) -> Array:
    """Return E_max,syst [m] `(count,)` of robots calibrated once and driven again, as in U Table I."""
    chance = np.random.default_rng(0)
    trucks = (calibrate(trial.drive(chance), "printed").truck for _ in range(count))
    return np.array([trial.drive(chance, truck).errors.e_max_syst for truck in trucks])


def left_over(trial: Trial, count: int, method: Method) -> Array:
    """Return E_max,syst [m] `(count,)` that robots calibrated once would have without any scatter."""
    chance = np.random.default_rng(0)
    sizes = []
    for _ in range(count):
        calibrated = calibrate(trial.drive(chance), method).truck
        ends = square_returns(calibrated, trial.actual, SIDE)
        sizes.append(float(np.hypot(ends[:, 0], ends[:, 1]).max()))
    return np.array(sizes)


def efficiency(trial: Trial, count: int, *, estimated_weights: bool = True) -> Array:
    """Return the mean square errors of E_b and E_d `(2,)` of the weighted fit over their Cramer-Rao bounds.

    The weights come from the scatter of the runs, as on a robot, or from the true covariance.
    """
    chance = np.random.default_rng(0)
    cw, ccw = (trial.runs_of(chance, direction, count) for direction in (0, 1))
    if estimated_weights:
        factors = weighted_factors(LABMATE, SIDE, cw, ccw)
    else:
        weights = weights_of(np.sqrt(np.diag(trial.covariance)), (trial.runs, trial.runs), SIDE)
        centres = np.stack([cw.mean(axis=1), ccw.mean(axis=1)], axis=1)
        factors = np.exp(fit_factors(centres, weights, LABMATE, SIDE)[0])
    square = np.mean((factors - [trial.e_b, trial.e_d]) ** 2, axis=0)
    bound = factor_bound((trial.e_b, trial.e_d), (trial.runs, trial.runs), trial.covariance)
    return np.asarray(square / np.diag(bound), np.float64)


def coverage(trial: Trial, count: int, method: Method, confidence: float = 0.95, seed: int = 0) -> Array:
    """Return the share `(2,)` of the delta method's intervals of E_b and E_d that contain the truth."""
    chance = np.random.default_rng(seed)
    held = []
    for _ in range(count):
        known = uncertainty_of(calibrate(trial.drive(chance), method), confidence)
        e_b, e_d = known.e_b, known.e_d
        held.append((e_b.low <= trial.e_b <= e_b.high, e_d.low <= trial.e_d <= e_d.high))
    return np.asarray(np.mean(held, axis=0), np.float64)


def free_coverage(trial: Trial, count: int, seed: int = 0) -> tuple[float, int]:
    """Return how often the interval of a wheelbase that is fitted with everything free holds the truth.

    The robot drives the squares on the simulator's floor, and its sonar gives a fix at each start and return.
    The fit has the wheelbase, both diameters, the reference's pose on the robot, its delay, the floor's
    roughness and the fixes' noise; what the drive does not tell, the fit itself holds. Returned are the share
    of the 95 % intervals that contain the truth, and the number of fits: some find no solution.
    """
    robot = reference_single()
    true = with_errors(robot, {"a": trial.e_b}, {"a": trial.e_d})
    wheelbase, held = true.trucks["a"].wheelbase, []
    for number in range(seed, seed + count):
        recording = simulate(robot, Truth(true, seed=number), umbmark(SIDE, trial.runs))
        try:
            fitted = calibrate_truck([recording], with_offset=True, with_time=True).quantities[0]
        except CalibrationError:
            continue
        held.append(fitted.low <= wheelbase <= fitted.high)
    return float(np.mean(held)), len(held)


def factor_bound(factors: tuple[float, float], runs: tuple[int, int], covariance: Array) -> Array:
    """Return the smallest covariance `(2, 2)` of E_b and E_d that an unbiased estimate can have.

    `runs` are the numbers of cw and of ccw runs; `covariance` is that of the return error x, y [m], theta
    [rad] of one ccw run, whose mirror image a cw run has. An infinite variance means: not measured.
    """
    logs = np.log(np.array(factors, np.float64))
    slopes = factor_ends(LABMATE, SIDE, logs)[1] / np.exp(logs)
    used = np.isfinite(np.diag(covariance))
    information = np.zeros((2, 2))
    for slope, count, mirror in zip(slopes, runs, (MIRROR, np.ones(3)), strict=True):
        scatter = (np.outer(mirror, mirror) * covariance)[used][:, used]
        information += count * slope[used].T @ np.linalg.solve(scatter, slope[used])
    return np.asarray(np.linalg.inv(information), np.float64)
