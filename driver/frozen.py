"""Finds wheels whose count stands still while the truck moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from driver.events import EventLog
    from vehicle.parameters import Channel, VehicleParameters
    from vehicle.sample import Sample

INTERVAL = 0.5  # [s] between two looks
MOVED = 0.01  # [m] in one interval: many counts of any encoder


class FrozenWatch:
    """Compares each wheel with its command, or with the other wheel of its truck where there is none."""

    def __init__(self, vehicle: VehicleParameters, events: EventLog) -> None:
        self._vehicle = vehicle
        self._events = events
        self._columns = {wheel: vehicle.channels.index(wheel) for wheel in vehicle.wheels}
        self._last: Sample | None = None
        self._speeds: tuple[float, ...] | None = None

    def check(self, sample: Sample, speeds: Sequence[float] | None) -> None:
        """Look at a sample and at the commanded speeds [rad/s] in the order of `vehicle.wheels`, if any."""
        if self._last is not None and sample.time - self._last.time < INTERVAL:
            return
        commands = None if speeds is None else tuple(speeds)
        if self._last is not None:
            for wheel in self._vehicle.wheels:
                if self._stands(wheel, sample) and self._should_move(wheel, sample, commands):
                    node = self._vehicle.encoder(wheel).node
                    what = (
                        f"{wheel}: count stands still while the truck moves: encoder frozen, or wheel blocked"
                    )
                    self._events.add(sample.time, node, what)
        self._last, self._speeds = sample, commands

    def _stands(self, wheel: Channel, sample: Sample) -> bool:
        column = self._columns[wheel]
        assert self._last is not None  # the caller has seen to it
        both = sample.present[column] and self._last.present[column]
        return both and sample.counts[column] == self._last.counts[column]

    def _should_move(self, wheel: Channel, sample: Sample, commands: tuple[float, ...] | None) -> bool:
        assert self._last is not None  # the caller has seen to it
        if commands is not None and self._speeds is not None:
            number = self._vehicle.wheels.index(wheel)
            slower = min(abs(commands[number]), abs(self._speeds[number]))
            same_way = commands[number] * self._speeds[number] > 0.0
            radius = self._vehicle.wheel_diameter(wheel) / 2.0
            return same_way and slower * radius * (sample.time - self._last.time) > MOVED
        other = next(one for one in self._vehicle.wheels if one[0] == wheel[0] and one != wheel)
        column = self._columns[other]
        travel = (sample.counts[column] - self._last.counts[column]) * self._vehicle.metres_per_count(other)
        return math.fabs(travel) > MOVED
