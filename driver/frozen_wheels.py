"""Finds wheels whose count stands still while the truck moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.event_log import EventLog
    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.sample import Sample

INTERVAL = 0.5  # [s] between two comparisons
MOVED = 0.01  # [m] in one interval: many counts of any encoder


class FrozenWheelWatch:
    """Compares each wheel with its command, or with the other wheel of its truck where there is none.

    Args:
        vehicle: Vehicle whose wheels are compared.
        events: Log that gets an event for each frozen wheel.
    """

    def __init__(self, vehicle: VehicleParameters, events: EventLog) -> None:
        self._vehicle = vehicle
        self._events = events
        self._columns = {wheel: vehicle.channels.index(wheel) for wheel in vehicle.wheels}
        self._last: Sample | None = None
        self._speeds: tuple[float, ...] | None = None

    def check(self, sample: Sample, speeds: Sequence[float] | None) -> None:
        """Compare a sample with an earlier one, at most every `INTERVAL`.

        Args:
            sample: Sample that has just been closed.
            speeds: Commanded speeds [rad/s] in the order of `vehicle.wheels`; None without commands.
        """
        last = self._last
        if last is not None and sample.time - last.time < INTERVAL:
            return
        commands = None if speeds is None else tuple(speeds)
        if last is not None:
            for wheel in self._vehicle.wheels:
                if self._stands(wheel, last, sample) and self._should_move(wheel, last, sample, commands):
                    what = (
                        f"{wheel}: count stands still while the truck moves: encoder frozen, or wheel blocked"
                    )
                    self._events.add(sample.time, self._vehicle.encoder(wheel).node, what)
        self._last, self._speeds = sample, commands

    def _stands(self, wheel: Channel, last: Sample, sample: Sample) -> bool:
        column = self._columns[wheel]
        both = sample.present[column] and last.present[column]
        return both and sample.counts[column] == last.counts[column]

    def _should_move(
        self, wheel: Channel, last: Sample, sample: Sample, commands: tuple[float, ...] | None
    ) -> bool:
        if commands is not None and self._speeds is not None:
            number = self._vehicle.wheels.index(wheel)
            slower = min(abs(commands[number]), abs(self._speeds[number]))
            same_way = commands[number] * self._speeds[number] > 0.0
            radius = self._vehicle.wheel_diameter(wheel) / 2.0
            return same_way and slower * radius * (sample.time - last.time) > MOVED
        other = next(name for name in self._vehicle.wheels if name[0] == wheel[0] and name != wheel)
        column = self._columns[other]
        travel = (sample.counts[column] - last.counts[column]) * self._vehicle.metres_per_count(other)
        return math.fabs(travel) > MOVED
