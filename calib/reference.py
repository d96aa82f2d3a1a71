"""The problem of a robot that is watched from outside: its kinematics, and where its reference sits.

Increments of odometry between absolute poses are taken as one correlated chain, not as independent errors of
a long roll-out: dead-reckoning errors grow with the way, so an early error shows in every later pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.chains import Chains, joined
from calib.filtering import accumulate
from calib.kinematics import Coordinate, Noise
from vehicle.odometry import integrate
from vehicle.se2 import between, compose, inverse

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from calib.drives import Drive
    from calib.kinematics import Kinematics
    from vehicle.se2 import Array

OFFSETS = (
    Coordinate("reference x", "m", 0.05),
    Coordinate("reference y", "m", 0.05),
    Coordinate("reference yaw", "rad", 0.1),
)
TIME_OFFSET = Coordinate("reference time", "s", 0.1)
POSITION = Noise("pose position", "m", 2e-3)
HEADING = Noise("pose heading", "rad", 4e-3)
STAMP = Noise("pose time stamp", "s", 1e-2)
ABSENT = 1e6  # [m^2, rad^2] variance of what was not measured
_EXACT = 1e-6  # [m, rad] a smaller sigma is none
_MOMENT = 0.05  # [s] half the time over which the speed at a fix is taken


@dataclass(frozen=True, slots=True)
class ReferenceProblem:
    """Drives of one robot, with a reference on it whose pose is measured.

    Attributes:
        drives: each one chain.
        kinematics: of the robot.
        with_offset: whether the reference's pose on the robot is estimated.
        with_time: whether its clock is: what it shows at t, the robot does at t + offset.
    """

    drives: tuple[Drive, ...]
    kinematics: Kinematics
    with_offset: bool = False
    with_time: bool = False

    @property
    def source(self) -> str:
        """Where the data came from."""
        names = list(dict.fromkeys(drive.source for drive in self.drives))
        return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Those of the kinematics, then the reference's."""
        offsets = OFFSETS if self.with_offset else ()
        return (*self.kinematics.coordinates, *offsets, *((TIME_OFFSET,) if self.with_time else ()))

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Those of the kinematics, then position and heading of poses without a stated sigma."""
        return (*self.kinematics.noises, POSITION, HEADING, STAMP)

    def place(self, number: int) -> tuple[str, float]:
        """Return the drive and the time [s] of a fix."""
        for drive in self.drives:
            if number < len(drive.fix_time):
                return drive.source, float(drive.fix_time[number])
            number -= len(drive.fix_time)
        raise IndexError(number)

    def chains(self, coordinates: Array) -> Chains:
        """Return one chain per drive, after each other."""
        lever = coordinates[self._place_of(OFFSETS[0])] if self.with_offset else np.zeros(3)
        delay = float(coordinates[-1]) if self.with_time else 0.0
        return joined([self._chain(drive, coordinates, lever, delay) for drive in self.drives], lever)

    def _place_of(self, first: Coordinate) -> slice:
        start = self.coordinates.index(first)
        return slice(start, start + len(OFFSETS))

    def _chain(self, drive: Drive, coordinates: Array, lever: Array, delay: float) -> Chains:
        own = coordinates[: len(self.kinematics.coordinates)]
        times = drive.fix_time + delay
        grid = np.union1d(drive.time, times)
        steps = self.kinematics.steps(_readings(drive, grid), own)
        ends = np.searchsorted(grid, times).astype(np.float64)
        moved, slope, process = accumulate(np.concatenate((ends[:1], ends[:-1])), ends, *steps)
        count, size = len(times), len(coordinates)
        sensitivity = np.zeros((count, 3, size))
        sensitivity[:, :, : len(own)] = slope
        first = np.zeros(count, np.bool_)
        first[0] = True
        start = np.zeros((count, 3))
        start[0] = _start(drive, moved, lever)
        stated, scatter = pose_noise(drive.pose, drive.sigma)
        speed = self._speed(drive, times, own)
        return Chains(
            first,
            start,
            np.zeros((count, 3)),
            moved,
            sensitivity,
            process,
            drive.pose,
            stated,
            np.concatenate([scatter, late(drive, speed)[np.newaxis]]),
            lever,
            self._effect(speed, lever, size),
        )

    def _speed(self, drive: Drive, times: Array, own: Array) -> Array:
        """Return the robot's speed `(M, 3)` at times [m/s, m/s, rad/s], body frame."""
        around = np.stack([times - _MOMENT, times + _MOMENT], axis=-1).reshape(-1)
        moved = self.kinematics.steps(_readings(drive, around), own).increment[::2]
        return np.asarray(moved / (2.0 * _MOMENT), np.float64)

    def _effect(self, speed: Array, lever: Array, size: int) -> Array:
        """Return how the reference's coordinates move the measured pose `(M, 3, P)`, body frame."""
        effect = np.zeros((len(speed), 3, size))
        if self.with_offset:
            effect[:, :, self._place_of(OFFSETS[0])] = np.eye(3)
        if self.with_time:
            effect[:, :, -1] = speed + np.outer(speed[:, 2], [-lever[1], lever[0], 0.0])
        return effect


def late(drive: Drive, speed: Array) -> Array:
    """Return the covariance `(M, 3, 3)` of poses per unit variance of their time [s^2], world frame.

    It is there only for poses without a stated sigma and with a known heading.
    """
    heading = drive.pose[:, 2]
    unstated = np.isnan(drive.sigma @ np.ones(3)) & np.isfinite(drive.pose @ np.ones(3))
    cos, sin = np.cos(heading), np.sin(heading)
    east, north = cos * speed[:, 0] - sin * speed[:, 1], sin * speed[:, 0] + cos * speed[:, 1]
    moving = np.where(unstated[:, np.newaxis], np.stack([east, north, speed[:, 2]], axis=-1), 0.0)
    return np.asarray(moving[:, :, np.newaxis] * moving[:, np.newaxis, :], np.float64)


def pose_noise(pose: Array, sigma: Array) -> tuple[Array, Array]:
    """Return the stated covariance `(M, 3, 3)` of poses; where it is not stated, shapes `(2, M, 3, 3)`."""
    known: NDArray[np.bool_] = np.isfinite(pose)
    said: NDArray[np.bool_] = np.isfinite(sigma)
    variance = np.where(said, np.maximum(np.nan_to_num(sigma), _EXACT) ** 2, 0.0)
    stated, scatter = np.zeros((len(pose), 3, 3)), np.zeros((2, len(pose), 3, 3))
    for axis in range(3):
        stated[:, axis, axis] = np.where(known[:, axis], variance[:, axis], ABSENT)
        scatter[int(axis == 2), :, axis, axis] = known[:, axis] & ~said[:, axis]
    return stated, scatter


def _readings(drive: Drive, times: Array) -> Array:
    """Return the readings `(G, 2)` at times, interpolated."""
    return np.stack([np.interp(times, drive.time, column) for column in drive.readings.T], axis=-1)


def _start(drive: Drive, moved: Array, lever: Array) -> Array:
    """Return the pose `(3,)` of the robot at the first fix, roughly, by those that are known."""
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

    Args:
        drive: readings and fixes.
        kinematics: of the robot.
        lever: pose `(3,)` of the reference on the robot, whose poses are then returned; None for the robot's.
    """
    place = np.zeros(3) if lever is None else lever
    nominal = np.zeros(len(kinematics.coordinates))
    steps = kinematics.steps(drive.readings, nominal)
    path = integrate(steps.increment)
    at = np.clip(np.searchsorted(drive.time, drive.fix_time), 0, len(path) - 1)
    passed = np.vstack([np.zeros((1, 3)), between(path[at[:-1]], path[at[1:]])])
    start = _start(drive, passed, place)
    return np.asarray(compose(compose(compose(start, inverse(path[at[0]])), path), place), np.float64)
