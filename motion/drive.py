"""Execution of a program on a robot's bus: a sample, a step and a command in turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.se2 import between, compose, wrap

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from omnimate.motion.journal import Journal
    from omnimate.motion.runner import Runner
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.sample import Sample
    from omnimate.vehicle.se2 import Array

    Fix = Callable[[TruckName], tuple[Array, Array]]

MAX_BLIND_TIME = 0.1  # [s] without a complete sample after which the robot is stopped (assumption)


class Robot(Protocol):
    """Interface of a robot; implemented by `omnimate.driver.robot.driver.Driver`."""

    def cycle(self) -> Sample:
        """Return the next sample."""
        ...

    def command(self, wheel_speeds: Sequence[float], /) -> object:
        """Turn the wheels, in the order of `vehicle.wheels` [rad/s]."""
        ...


@dataclass(frozen=True, slots=True)
class Moment:
    """State of the drive after a sample."""

    sample: Sample
    pose: PoseTuple  # pose of truck a by odometry, before a fix
    lap: int | None  # number of the lap that is being driven, from 0; None between laps
    fix: Array | None = None  # absolute pose of truck a measured now, `(3,)`; odometry goes on from it

    @property
    def error(self) -> PoseTuple | None:
        """Absolute pose minus odometry's x, y, theta [m, m, rad], U (3.1); None without a fix."""
        if self.fix is None:
            return None
        x, y, theta = (float(value) for value in self.fix)
        return x - self.pose[0], y - self.pose[1], float(wrap(theta - self.pose[2]))


def drive(
    robot: Robot,
    runner: Runner,
    vehicle: VehicleParameters,
    journal: Journal,
    fix: Fix | None = None,
    locate: Callable[[Sample], PoseTuple] | None = None,
) -> Iterator[Moment]:
    """Execute a runner's program and yield after each sample; the caller may stop early.

    Odometry restarts at each fix, U III-C 1). Where encoders are missing, the wheels are commanded to
    stand before `MAX_BLIND_TIME` has passed since the last complete sample, and the program waits. A sample
    ends up to one SYNC period after its time, and the next one another period later: this is the last one
    that is soon enough. With a SYNC period of more than half of `MAX_BLIND_TIME`, it is the first incomplete
    one.

    Args:
        robot: The robot, with its drives enabled.
        runner: The runner, at the beginning of its program.
        vehicle: The vehicle with the parameters that odometry uses.
        journal: Journal that keeps laps and fixes.
        fix: Measures the absolute pose `(3,)` of a truck and its sigma `(3,)`, nan where unknown; None
            where nothing measures it.
        locate: Returns the pose of truck a by odometry after a sample, from any start; None where the caller
            has no odometry of its own.
    """
    odometer = Odometer(vehicle, "a") if locate is None else _MovedOdometer(locate)
    reader = LinkReader(vehicle)
    last_complete, patience = -np.inf, MAX_BLIND_TIME - 2.0 * vehicle.bus.sync_period
    while not runner.done:
        sample = robot.cycle()
        pose = odometer.step(sample)
        if all(sample.present):
            last_complete = sample.time
        elif sample.time - last_complete > patience:
            robot.command(runner.halt())
            yield Moment(sample, pose, runner.lap)
            continue
        robot.command(runner.step(pose, reader.read(sample.counts)))
        journal.observe(sample.time, runner)
        where = _measure_fixes(sample.time, vehicle, journal, fix) if runner.fix_due and fix else None
        if where is not None:
            odometer.pose = (float(where[0]), float(where[1]), float(where[2]))
        yield Moment(sample, pose, runner.lap, where)


class _MovedOdometer:
    """Turns the poses of another odometry into poses from zero, and from each `pose` that is set."""

    def __init__(self, locate: Callable[[Sample], PoseTuple]) -> None:
        self.pose: PoseTuple = (0.0, 0.0, 0.0)
        self._locate = locate
        self._last: PoseTuple | None = None

    def step(self, sample: Sample) -> PoseTuple:
        """Process one sample and return the pose after it."""
        last, self._last = self._last, self._locate(sample)
        if last is not None:
            x, y, theta = compose(self.pose, between(last, self._last)).tolist()
            self.pose = x, y, theta
        return self.pose


def _measure_fixes(time: float, vehicle: VehicleParameters, journal: Journal, fix: Fix) -> Array | None:
    """Measure every truck; return the pose of truck a `(3,)` where it was seen."""
    where = None
    for truck in vehicle.trucks:
        pose, sigma = fix(truck)
        journal.fix(time, truck, pose, sigma)
        if truck == "a" and np.isfinite(pose).all():
            where = pose
    return where


class LinkReader:
    """Converts the counts of a sample to joint angles and link length; None for a single truck."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._columns: list[tuple[int, int, float]] = []
        self._length = 0.0
        if vehicle.linkage is not None:
            self._length = vehicle.linkage.length
            for channel in CHANNELS[4:]:
                encoder = vehicle.encoder(channel)
                self._columns.append((vehicle.channels.index(encoder.channel), encoder.zero, encoder.scale))

    def read(self, counts: Sequence[int]) -> tuple[float, float, float] | None:
        """Return joint_a [rad], joint_b [rad] and the length [m] for counts in the order of the channels."""
        if not self._columns:
            return None
        joint_a, joint_b, link = [(counts[column] - zero) * scale for column, zero, scale in self._columns]
        return joint_a, joint_b, self._length + link
