"""Wheelbase, wheel diameters and the sensor's pose on the robot, from relative poses of the sensor.

The model is that of Censi, Franchi, Marchionni & Oriolo, Simultaneous calibration of odometry and sensor
parameters for mobile robots, IEEE Transactions on Robotics 29 (2013): while the robot moves by o, its sensor,
which sits at l, sees the motion inverse(l) (+) o (+) l. Theirs is a closed form with equal weights; this is
maximum likelihood from that start: the floor's roughness (Chong & Kleeman, 1997) and each pose's own
uncertainty weigh, so that the Cramer-Rao bound is reached.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.distributions import chi2_quantile
from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.chains import Coordinate
from omnimate.calib.estimation.estimates import Estimate
from omnimate.calib.estimation.filtering import join_steps
from omnimate.calib.estimation.observability import information_bound, unobservable
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import quantities
from omnimate.calib.relative.motions import missing_motion
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.odometry import truck_travel
from omnimate.vehicle.se2 import between, compose, inverse, rotation, transport, wrap

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.calib.estimation.observability import Held
    from omnimate.calib.paths.least_squares import Quantity
    from omnimate.calib.relative.motions import Motions
    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

# Prior: the sensor is anywhere on a robot of a metre, with any yaw.
SENSOR = (
    Coordinate("sensor x", "m", 0.5),
    Coordinate("sensor y", "m", 0.5),
    Coordinate("sensor yaw", "rad", 1.0),
)
MIN_MOTIONS = 6  # 18 equations for six unknowns
MAX_ROUNDS = 50
CONVERGED = 1e-6  # [standard deviations] largest change of a coordinate in the last round
OUTLIER_THRESHOLD = chi2_quantile(0.999, 3)  # squared distance above which a motion is down-weighted (Huber)


@dataclass(frozen=True, slots=True)
class RelativeCalibration:
    """The calibration of a truck and of a sensor's pose on it."""

    source: str  # where the relative poses come from
    estimate: Estimate  # coordinates of the truck, then x, y [m] and yaw [rad] of the sensor on it
    truck: Truck
    sensor: Array  # pose of the sensor on the truck, `(3,)`
    quantities: tuple[Quantity, ...]  # sizes of the truck and the sensor's pose, with intervals
    missing_motion: str | None  # kind of motion that is missing; None if all coordinates are identified
    outlying: int  # number of down-weighted motions


class _Wheels:
    """The wheels' angles, and `travel`, their nominal travel in each of the motions [m], `(K, 2)`."""

    def __init__(self, time: Array, readings: Array, truck: Truck, motions: Motions) -> None:
        grid = np.unique(np.concatenate([time, motions.start, motions.end]))
        self._readings = np.column_stack([np.interp(grid, time, column) for column in readings.T])
        first, last = np.searchsorted(grid, motions.start), np.searchsorted(grid, motions.end)
        self._ends = first.astype(np.float64), last.astype(np.float64)
        self.travel = (self._readings[last] - self._readings[first]) * truck.radii

    def moves(self, model: Differential, coordinates: Array) -> tuple[Array, Array, Array]:
        """Return the robot's motions at coordinates of the truck, with slopes and noise as `join_steps`."""
        return join_steps(*self._ends, *model.steps(self._readings, coordinates))


def calibrate_relative(recording: Recording, motions: Motions, truck: TruckName) -> RelativeCalibration:
    """Return the calibration of a truck and of a sensor's pose on it by relative poses of the sensor.

    Of the recording only the wheels are used; absolute poses are not needed.

    Raises:
        CalibrationError: There are too few motions, they overlap or are not within the recording, or nothing
            at all is identified.
    """
    sizes = recording.vehicle.trucks[truck]
    left, right, _ = truck_travel(recording, truck)
    return calibrate_wheels(recording.time, np.column_stack([left, right]) / sizes.radii, sizes, motions)


def calibrate_wheels(time: Array, readings: Array, truck: Truck, motions: Motions) -> RelativeCalibration:
    """Return the calibration of a truck by the angles of its wheels, as `calibrate_relative`.

    `readings` `(N, 2)` are the angles of the left and the right wheel [rad] at `time` `(N,)` [s].

    Raises:
        CalibrationError: As `calibrate_relative`.
    """
    _check(time, motions)
    wheels = _Wheels(time, readings, truck, motions)
    model = Differential(truck)
    size = len(model.coordinates)
    coordinates, moves = np.zeros(size), wheels.moves(model, np.zeros(size))
    sensor = _start(moves[0], motions.pose)
    parameters = (*model.coordinates, *SENSOR)
    information, _, _ = _linear(moves, motions, sensor)
    held, free = unobservable(parameters, information, np.ones(len(parameters), np.bool_))
    missing = missing_motion(wheels.travel, truck.wheelbase) if held else None
    if not free.any():
        raise CalibrationError(
            motions.source, f"the motions identify nothing; {missing or 'drive more, with turns'}"
        )
    sensor = np.where(free[size:], sensor, 0.0)
    for _ in range(MAX_ROUNDS):
        information, score, weights = _linear(wheels.moves(model, coordinates), motions, sensor)
        bound = information_bound(information, free)
        step = bound @ np.where(free, score, 0.0)
        coordinates = coordinates + step[:size]
        sensor = compose(sensor, step[size:])
        settled = np.abs(step[free]) / np.sqrt(np.diag(bound)[free])
        if settled.max() < CONVERGED:
            break
    return _result(model, motions, coordinates, sensor, (information, weights, free), held, missing)


def _check(time: Array, motions: Motions) -> None:
    if len(motions.start) < MIN_MOTIONS:
        raise CalibrationError(
            motions.source, f"{len(motions.start)} relative poses; {MIN_MOTIONS} or more needed"
        )
    if np.any(motions.start[1:] < motions.end[:-1] - 1e-9):
        raise CalibrationError(
            motions.source, "relative poses overlap or go back in time; each must begin where the last ended"
        )
    first, last = float(time[0]), float(time[-1])
    if motions.start[0] < first or motions.end[-1] > last:
        raise CalibrationError(
            motions.source,
            f"relative poses from {motions.start[0]:.3f} s to {motions.end[-1]:.3f} s are not within the "
            f"recording, {first:.3f} s to {last:.3f} s; they must share its clock",
        )


def _start(moves: Array, seen: Array) -> Array:
    """Return the best-fitting sensor pose for given motions of the robot: linear in x, y, cos, sin.

    It is equation (24) of Censi et al. with the wheelbase known: R(yaw) s = o + (R(theta) - 1) (x, y).
    """
    cos, sin = np.cos(moves[:, 2]), np.sin(moves[:, 2])
    above = np.column_stack([1.0 - cos, sin, seen[:, 0], -seen[:, 1]])
    below = np.column_stack([-sin, 1.0 - cos, seen[:, 1], seen[:, 0]])
    solved = np.linalg.lstsq(np.concatenate([above, below]), moves[:, :2].T.reshape(-1), rcond=1e-9)[0]
    return np.array([solved[0], solved[1], math.atan2(solved[3], solved[2])])


def _linear(moves: tuple[Array, Array, Array], motions: Motions, sensor: Array) -> tuple[Array, Array, Array]:
    """Return information `(6, 6)`, score `(6,)` and the weights `(K,)` of the motions, at a linearisation."""
    moved, slopes, noise = moves
    predicted = compose(compose(inverse(sensor), moved), sensor)
    residual = between(predicted, motions.pose)
    residual[:, 2] = wrap(residual[:, 2])
    into = transport(sensor)
    by_sensor = np.eye(3) - transport(predicted)
    jacobian = np.concatenate([into @ slopes, by_sensor], axis=2)
    covariance = CONCRETE_ROUGHNESS**2 * (into @ noise.sum(axis=0) @ into.T)
    covariance = covariance + motions.sigma[:, :, np.newaxis] ** 2 * np.eye(3)
    whitening = np.linalg.inv(np.linalg.cholesky(covariance))
    white, white_slopes = (whitening @ residual[:, :, np.newaxis])[:, :, 0], whitening @ jacobian
    distance = (white**2).sum(axis=1)
    weights = np.minimum(1.0, np.sqrt(OUTLIER_THRESHOLD / np.maximum(distance, 1e-300)))
    weighed = white_slopes * weights[:, np.newaxis, np.newaxis]
    information = np.einsum("kij,kil->jl", weighed, white_slopes)
    return information, np.einsum("kij,ki->j", weighed, white), np.column_stack([weights, distance])


def _result(
    model: Differential,
    motions: Motions,
    coordinates: Array,
    sensor: Array,
    fit: tuple[Array, Array, NDArray[np.bool_]],
    held: tuple[Held, ...],
    missing: str | None,
) -> RelativeCalibration:
    information, weights, free = fit
    size = len(model.coordinates)
    freedom = 3.0 * len(weights) - float(free.sum())
    rms = math.sqrt(float((weights[:, 0] * weights[:, 1]).sum()) / freedom)
    # Larger residuals than stated widen the bound; smaller ones do not narrow it.
    covariance = information_bound(information, free) * max(1.0, rms) ** 2
    turn = np.eye(size + 3)
    turn[size:, size:] = rotation(-sensor[2]) if free[-1] else np.eye(3)  # x and y along the robot's axes
    covariance = turn @ covariance @ turn.T
    parameters = (*model.coordinates, *SENSOR)
    scales = np.array([parameter.prior_sigma for parameter in parameters])
    inside = np.ix_(free, free)
    estimate = Estimate(
        parameters,
        np.concatenate([coordinates, sensor]),
        covariance,
        held,
        float(np.linalg.cond((information * np.outer(scales, scales))[inside])),
        (),
        freedom,
        (),
        len(weights),
        rms,
    )

    def values(place: Array) -> dict[str, float]:
        names = (coordinate.name for coordinate in SENSOR)
        sensed = dict(zip(names, map(float, place[size:]), strict=True))
        return model.values(place[:size]) | sensed

    return RelativeCalibration(
        motions.source,
        estimate,
        model.truck_at(coordinates),
        sensor,
        quantities(values, size + 3, estimate),
        missing,
        int((weights[:, 0] < 1.0).sum()),
    )
