"""Follows a robot on a bus by its odometry."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.robot.passive import PassiveReader
from omnimate.files.logs.decoding import encoder_conversion
from omnimate.vehicle.odometry import Odometer

if TYPE_CHECKING:
    from collections.abc import Mapping

    import can

    from omnimate.driver.bus.clock import Clock
    from omnimate.driver.canopen.network import FrameSink
    from omnimate.driver.robot.events import Event
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters
    from omnimate.vehicle.sample import Sample

LINKAGE: tuple[Channel, ...] = ("joint_a", "joint_b", "link")
SPAN = 4  # snapshots over which speeds and the load of the bus are taken


@dataclass(frozen=True, slots=True)
class RobotView:
    """Where the robot is by the last sample."""

    samples: int  # number of samples
    missing: tuple[Channel, ...]  # channels that the last sample lacks
    linkage: Mapping[Channel, float]  # angle of each joint [rad] and length of the link [m]
    # speed of each wheel over the last second [m/s], by the time stamps of its frames
    speeds: Mapping[Channel, float]
    # pose of each truck by odometry, from zero at the first sample [m, m, rad]
    poses: Mapping[TruckName, PoseTuple]


class RobotWatch:
    """The robot by its odometry, which continues from the last pose when a lost bus is back."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._vehicle = vehicle
        self._reader: PassiveReader | None = None
        self._poses: dict[TruckName, PoseTuple] = dict.fromkeys(vehicle.trucks, (0.0, 0.0, 0.0))
        self._samples = 0
        self._sample: Sample | None = None
        self._before: deque[Sample] = deque(maxlen=SPAN + 1)

    def follow(self, bus: can.BusABC, recorder: FrameSink, clock: Clock) -> None:
        """Take the samples of a bus until it fails with BusError; a recorder gets its frames."""
        self._reader = PassiveReader(self._vehicle, bus, recorder=recorder, clock=clock)
        self._before.clear()
        odometers = {truck: Odometer(self._vehicle, truck, start) for truck, start in self._poses.items()}
        for sample in self._reader.samples(idle=math.inf, patience=math.inf):
            for truck, odometer in odometers.items():
                self._poses[truck] = odometer.step(sample)
            self._samples += 1
            self._sample = sample

    def events(self) -> tuple[Event, ...]:
        """Return the events of the robot's nodes."""
        return () if self._reader is None else self._reader.report().events

    def view(self) -> RobotView | None:
        """Return where the robot is by the last sample; None before the first."""
        sample, vehicle = self._sample, self._vehicle
        if sample is None:
            return None
        if not self._before or self._before[-1] is not sample:
            self._before.append(sample)
        columns = {channel: column for column, channel in enumerate(vehicle.channels)}
        speeds = {wheel: self._speed(wheel, columns[wheel]) for wheel in vehicle.wheels}
        linkage = {
            encoder.channel: encoder_conversion(encoder, vehicle)(sample.counts[columns[encoder.channel]])
            for encoder in vehicle.encoders
            if encoder.channel in LINKAGE
        }
        present = zip(vehicle.channels, sample.present, strict=True)
        missing = tuple(channel for channel, is_present in present if not is_present)
        return RobotView(self._samples, missing, linkage, speeds, dict(self._poses))

    def _speed(self, wheel: Channel, column: int) -> float:
        """Return the speed of a wheel over the last `SPAN` snapshots [m/s]; nan where it is unknown."""
        samples = [sample for sample in self._before if sample.present[column]]
        if len(samples) < 2:
            return math.nan
        first, last = samples[0], samples[-1]
        passed = last.device_time[column] - first.device_time[column]
        if not passed > 0.0:  # an adapter without time stamps
            passed = last.time - first.time
        counts = last.counts[column] - first.counts[column]
        return counts * self._vehicle.metres_per_count(wheel) / passed if passed > 0.0 else math.nan
