"""Ideal drives for the path designer: wheel angles of straights, spins and arcs, with fixes at the stops."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.paths.drives import Drive

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Truck
    from omnimate.vehicle.se2 import Array

_TRAVEL_STEP = 0.1  # [m] of wheel travel in one step
SPEED = 0.2  # [m/s] of the wheels, U III-C


@dataclass(slots=True)
class PlannedDrive:
    """A builder of drives, as travel of the wheels."""

    truck: Truck  # the truck that drives it
    travel: list[Array] = field(default_factory=list)  # of both wheels in each step [m], `(2,)`
    fixes: list[int] = field(default_factory=list)  # steps after which an absolute pose is measured

    def straight(self, length: float) -> PlannedDrive:
        """Add a straight of a length [m]; a negative length is driven backwards."""
        return self._go(length, length)

    def spin(self, angle: float) -> PlannedDrive:
        """Add a turn on the spot by an angle [rad], left positive."""
        rim = 0.5 * self.truck.wheelbase * angle
        return self._go(-rim, rim)

    def arc(self, radius: float, angle: float) -> PlannedDrive:
        """Add an arc of a radius [m] driven forwards, by an angle [rad], left positive."""
        length, rim = radius * abs(angle), 0.5 * self.truck.wheelbase * angle
        return self._go(length - rim, length + rim)

    def fix(self) -> PlannedDrive:
        """Add a stop at which the pose is measured."""
        self.fixes.append(len(self.travel))
        return self

    def _go(self, left: float, right: float) -> PlannedDrive:
        count = max(1, math.ceil(max(abs(left), abs(right)) / _TRAVEL_STEP))
        self.travel += [np.array([left, right]) / count] * count
        return self

    @property
    def rolled(self) -> float:
        """Distance that the wheels roll [m], the mean of both."""
        return float(np.abs(np.array(self.travel)).mean(axis=1).sum())

    def measured(self, sigma: Array, source: str) -> Drive:
        """Return the measured drive; its fixes have standard deviations `(3,)`, nan where not measured."""
        readings = np.vstack([np.zeros((1, 2)), np.cumsum(self.travel, axis=0) / self.truck.radii])
        time = np.arange(len(readings), dtype=np.float64) * (_TRAVEL_STEP / SPEED)
        count = len(self.fixes)
        pose = np.tile(np.where(np.isfinite(sigma), 0.0, np.nan), (count, 1))
        return Drive(time, readings, time[np.array(self.fixes)], pose, np.tile(sigma, (count, 1)), source)


def square(truck: Truck, side: float, sign: int) -> PlannedDrive:
    """Return the square of U III-C in one direction, +1 ccw or -1 cw, with fixes before and after."""
    drive = PlannedDrive(truck).fix()
    for _ in range(4):
        drive.straight(side).spin(sign * 0.5 * math.pi)
    return drive.fix()


def out_and_back(truck: Truck, length: float) -> PlannedDrive:
    """Return a straight out and back in reverse, C 6.1, with fixes before and after."""
    return PlannedDrive(truck).fix().straight(length).straight(-length).fix()


def open_straight(truck: Truck, length: float) -> PlannedDrive:
    """Return a straight with fixes at both ends."""
    return PlannedDrive(truck).fix().straight(length).fix()


def counted_spin(truck: Truck, turns: int) -> PlannedDrive:
    """Return whole turns on the spot, left positive, with fixes before and after."""
    return PlannedDrive(truck).fix().spin(2.0 * math.pi * turns).fix()


def figure_eight(truck: Truck, radius: float) -> PlannedDrive:
    """Return a circle to the left and one to the right, with fixes before and after."""
    return PlannedDrive(truck).fix().arc(radius, 2.0 * math.pi).arc(radius, -2.0 * math.pi).fix()


def free_lap(truck: Truck, length: float, width: float, chance: np.random.Generator) -> PlannedDrive:
    """Return a drive past six random points of a rectangle and home again, with fixes before and after."""
    points = [*chance.uniform([0.0, -0.5 * width], [length, 0.5 * width], (6, 2)), np.zeros(2)]
    drive, place, heading = PlannedDrive(truck).fix(), np.zeros(2), 0.0
    for point in points:
        east, north = point - place
        wanted = math.atan2(north, east)
        turn = math.remainder(wanted - heading, 2.0 * math.pi)
        drive.spin(turn).straight(math.hypot(east, north))
        place, heading = point, heading + turn
    return drive.spin(math.remainder(-heading, 2.0 * math.pi)).fix()
