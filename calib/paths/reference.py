"""The calibration problem of a robot whose reference is measured from outside: kinematics and reference.

Increments of odometry between absolute poses are treated as one correlated chain and not as independent
errors of a whole path: dead-reckoning errors grow with the distance, so an early error shows in every later
pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.estimation.chains import Chains, Coordinate, NoiseSource, concatenate_chains
from omnimate.calib.estimation.filtering import join_steps
from omnimate.vehicle.arcs import integrate
from omnimate.vehicle.se2 import between, compose, inverse, rotate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.calib.paths.drives import Drive
    from omnimate.calib.paths.kinematics import Kinematics
    from omnimate.vehicle.se2 import Array

OFFSETS = (
    Coordinate("reference x", "m", 0.05),
    Coordinate("reference y", "m", 0.05),
    Coordinate("reference yaw", "rad", 0.1),
)
TIME_OFFSET = Coordinate("reference time", "s", 0.1)
POSITION = NoiseSource("pose position", "m", 2e-3)
HEADING = NoiseSource("pose heading", "rad", 4e-3)
STAMP = NoiseSource("pose time stamp", "s", 1e-2)
UNMEASURED_VARIANCE = 1e6  # [m^2, rad^2] of a component that was not measured: practically infinite
_MIN_SIGMA = 1e-6  # [m, rad] lower limit of stated standard deviations, for numerical stability
_SPEED_HALF_TIME = 0.05  # [s] half of the interval over which the speed at a fix is averaged (assumption)


@dataclass(frozen=True, slots=True)
class ReferenceProblem:
    """Drives of one robot, with a reference on it whose pose is measured."""

    drives: tuple[Drive, ...]  # drives of the robot; each is a chain
    kinematics: Kinematics  # nominal kinematic model of the robot
    with_offset: bool = False  # whether the reference's pose on the robot is estimated
    with_time: bool = False  # whether its clock's offset is estimated: at t it shows the robot at t + offset

    @property
    def source(self) -> str:
        """Files or folders that the data come from."""
        names = list(dict.fromkeys(drive.source for drive in self.drives))
        return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the kinematics, then those of the reference."""
        offsets = OFFSETS if self.with_offset else ()
        return (*self.kinematics.coordinates, *offsets, *((TIME_OFFSET,) if self.with_time else ()))

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """Noise of the kinematics, then position, heading and time of poses without a stated sigma."""
        return (*self.kinematics.noises, POSITION, HEADING, STAMP)

    def fixes(self) -> list[tuple[str, float]]:
        """Return the drive and the time [s] of each fix."""
        return [(drive.source, time) for drive in self.drives for time in drive.fix_time.tolist()]

    def chains(self, coordinates: Array) -> Chains:
        """Return a chain for each drive, one after the other."""
        lever = coordinates[self._place_of(OFFSETS[0])] if self.with_offset else np.zeros(3)
        delay = float(coordinates[-1]) if self.with_time else 0.0
        return concatenate_chains(
            [self._chain(drive, coordinates, lever, delay) for drive in self.drives], lever
        )

    def _place_of(self, first: Coordinate) -> slice:
        start = self.coordinates.index(first)
        return slice(start, start + len(OFFSETS))

    def _chain(self, drive: Drive, coordinates: Array, lever: Array, delay: float) -> Chains:
        robot = coordinates[: len(self.kinematics.coordinates)]
        times = drive.fix_time + delay
        grid = np.union1d(drive.time, times)
        steps = self.kinematics.steps(_readings(drive, grid), robot)
        ends = np.searchsorted(grid, times).astype(np.float64)
        moved, slope, process = join_steps(np.concatenate((ends[:1], ends[:-1])), ends, *steps)
        count, size = len(times), len(coordinates)
        sensitivity = np.zeros((count, 3, size))
        sensitivity[:, :, : len(robot)] = slope
        start = np.zeros((count, 3))
        start[0] = _start(drive, moved, lever)
        stated, scatter = pose_noise(drive.pose, drive.sigma)
        speed = self._speed(drive, times, robot)
        return Chains(
            np.arange(count) == 0,
            start,
            np.zeros((count, 3)),
            moved,
            sensitivity,
            process,
            drive.pose,
            stated,
            np.concatenate([scatter, timing_covariance(drive, speed)[np.newaxis]]),
            lever,
            self._effect(speed, lever, size),
        )

    def _speed(self, drive: Drive, times: Array, robot: Array) -> Array:
        """Return the robot's speed `(M, 3)` at times [m/s, m/s, rad/s], body frame."""
        around = np.stack([times - _SPEED_HALF_TIME, times + _SPEED_HALF_TIME], axis=-1).reshape(-1)
        moved = self.kinematics.steps(_readings(drive, around), robot).increment[::2]
        return np.asarray(moved / (2.0 * _SPEED_HALF_TIME), np.float64)

    def _effect(self, speed: Array, lever: Array, size: int) -> Array:
        """Return the derivative `(M, 3, P)` of measured poses by the reference's coordinates, body frame."""
        effect = np.zeros((len(speed), 3, size))
        if self.with_offset:
            effect[:, :, self._place_of(OFFSETS[0])] = np.eye(3)
        if self.with_time:
            effect[:, :, -1] = speed + np.outer(speed[:, 2], [-lever[1], lever[0], 0.0])
        return effect


def timing_covariance(drive: Drive, speed: Array) -> Array:
    """Return the covariance `(M, 3, 3)` of poses per unit variance of their time [s^2], world frame.

    It is zero except for poses without a stated sigma and with a known heading.
    """
    heading = drive.pose[:, 2]
    unstated = np.isnan(drive.sigma @ np.ones(3)) & np.isfinite(drive.pose @ np.ones(3))
    moving = np.column_stack([rotate(heading, speed[:, :2]), speed[:, 2]])
    moving = np.where(unstated[:, np.newaxis], moving, 0.0)
    return np.asarray(moving[:, :, np.newaxis] * moving[:, np.newaxis, :], np.float64)


def pose_noise(pose: Array, sigma: Array) -> tuple[Array, Array]:
    """Return the covariance of poses `(M, 3)`: the stated part, and the part of unknown size.

    A component of `pose` is nan where it is unknown, one of `sigma` where none is stated. The first part is
    `(M, 3, 3)`, the second `(2, M, 3, 3)` per unit variance of position and of heading.
    """
    known: NDArray[np.bool_] = np.isfinite(pose)
    said: NDArray[np.bool_] = np.isfinite(sigma)
    variance = np.where(said, np.maximum(np.nan_to_num(sigma), _MIN_SIGMA) ** 2, 0.0)
    stated, scatter = np.zeros((len(pose), 3, 3)), np.zeros((2, len(pose), 3, 3))
    for axis in range(3):
        stated[:, axis, axis] = np.where(known[:, axis], variance[:, axis], UNMEASURED_VARIANCE)
        scatter[int(axis == 2), :, axis, axis] = known[:, axis] & ~said[:, axis]
    return stated, scatter


def _readings(drive: Drive, times: Array) -> Array:
    """Return the readings `(G, 2)` at times, interpolated."""
    return np.stack([np.interp(times, drive.time, column) for column in drive.readings.T], axis=-1)


def _start(drive: Drive, moved: Array, lever: Array) -> Array:
    """Return the approximate pose `(3,)` of the robot at the first fix, from known components of fixes."""
    path = integrate(moved[1:])
    measured = drive.pose
    known = np.flatnonzero(np.isfinite(measured).all(axis=1))
    if len(known):
        there = compose(measured[known[0]], inverse(lever))
        return np.asarray(compose(there, between(path[known[0]], path[0])), np.float64)
    placed = np.flatnonzero(np.isfinite(measured[:, :2]).all(axis=1))
    if len(placed) < 2:
        return np.zeros(3)
    seen = measured[placed, 0] + 1j * measured[placed, 1]
    gone = path[placed, 0] + 1j * path[placed, 1]
    turn = float(np.angle(np.sum((seen - seen.mean()) * np.conj(gone - gone.mean()))))
    origin = seen[0] - gone[0] * complex(math.cos(turn), math.sin(turn))
    return np.array([origin.real, origin.imag, turn])


def dead_reckoned(drive: Drive, kinematics: Kinematics, lever: Array | None = None) -> Array:
    """Return the poses `(N, 3)` that a model's odometry gives at every reading, from the first fix.

    They are those of the reference at `lever` `(3,)` on the robot; without it, those of the robot.
    """
    place = np.zeros(3) if lever is None else lever
    nominal = np.zeros(len(kinematics.coordinates))
    steps = kinematics.steps(drive.readings, nominal)
    path = integrate(steps.increment)
    at = np.clip(np.searchsorted(drive.time, drive.fix_time), 0, len(path) - 1)
    passed = np.vstack([np.zeros((1, 3)), between(path[at[:-1]], path[at[1:]])])
    start = _start(drive, passed, place)
    return np.asarray(compose(compose(compose(start, inverse(path[at[0]])), path), place), np.float64)
