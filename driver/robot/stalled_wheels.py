"""Finds wheels whose count stands still although they should turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.vehicle.bridging import partners

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.sample import Sample

# Limits of the driver; no standard states them.
STALL_TIME = 0.5  # [s] without a count: brakes, backlash and ramps of a drive take less
MIN_TRAVEL = 0.01  # [m] that the wheel should have moved by then: many counts of most encoders
MIN_COUNTS = 4.0  # [counts] for coarser encoders


@dataclass(slots=True)
class _Wheel:
    """One wheel since its count last changed."""

    wheel: Channel  # channel of the wheel
    column: int  # column of the wheel in a sample
    other: int  # column of the truck's other wheel
    radius: float  # radius of the wheel [m]
    other_scale: float  # travel per count of the other wheel [m]
    enough: float  # travel that must show in the count [m]
    since: float | None = None  # time of the first sample with this count [s]; None before it
    count: int = 0
    expected: float = 0.0  # travel that the wheel should have made since [m]; negative backwards


class StallDetector:
    """Compares each wheel with its command, or with the other wheel of its truck where there is none.

    A wheel has stalled when its count has not changed for `STALL_TIME`, and its command, all that time in the
    same direction, would have moved it by `MIN_TRAVEL` or `MIN_COUNTS`. A sample without its count restarts
    the timer; without a command so does one without the other count, whose travel comes at once after it.
    """

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._wheels = []
        self._last: Sample | None = None
        for column, other in partners(vehicle).items():
            wheel = vehicle.channels[column]
            enough = max(MIN_TRAVEL, MIN_COUNTS * abs(vehicle.metres_per_count(wheel)))
            scale = vehicle.metres_per_count(vehicle.channels[other])
            radius = vehicle.wheel_diameter(wheel) / 2.0
            self._wheels.append(_Wheel(wheel, column, other, radius, scale, enough))

    def check(self, sample: Sample, speeds: Sequence[float] | None) -> list[Channel]:
        """Return the wheels that have stalled by this sample; each at most once in `STALL_TIME`.

        `speeds` are commanded [rad/s] in the order of `vehicle.wheels`; None without commands.
        """
        last, self._last = self._last, sample
        if last is None:
            return []
        stalled = []
        for number, wheel in enumerate(self._wheels):
            speed = None if speeds is None else speeds[number]
            if _has_stalled(wheel, last, sample, speed):
                stalled.append(wheel.wheel)
        return stalled


def _has_stalled(wheel: _Wheel, last: Sample, sample: Sample, speed: float | None) -> bool:
    """Take one sample of a wheel; return whether the wheel has stalled."""
    count = sample.counts[wheel.column]
    is_read = sample.present[wheel.column] and last.present[wheel.column]
    if speed is None:
        is_read = is_read and sample.present[wheel.other] and last.present[wheel.other]
        travel = (sample.counts[wheel.other] - last.counts[wheel.other]) * wheel.other_scale
    else:
        travel = speed * wheel.radius * (sample.time - last.time)
    turned_back = travel * wheel.expected < 0.0
    is_commanded_to_stand = speed == 0.0
    if wheel.since is None or not is_read or count != wheel.count or turned_back or is_commanded_to_stand:
        wheel.since, wheel.count, wheel.expected = sample.time, count, 0.0
        return False
    wheel.expected += travel
    has_stalled = sample.time - wheel.since >= STALL_TIME and math.fabs(wheel.expected) > wheel.enough
    if has_stalled:
        wheel.since, wheel.expected = sample.time, 0.0
    return has_stalled
