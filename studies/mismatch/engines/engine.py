"""The engine: a small simulator that shares no code with the project's own.

It integrates by the midpoint rule at a quarter of the sample period, or finer. Truck a drives a programme by
its nominal wheels; truck b follows the true angles and length of the linkage. It needs numpy alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from studies.mismatch.engines.faults import (
    ConcealedFault,
    Place,
    TruckStep,
    WheelStep,
    felt,
    moved,
    shown,
    touches,
    travelled,
)
from studies.mismatch.engines.laws import counted_share, of_age
from studies.mismatch.engines.programmes import Lap, commands, wheel_ways
from studies.mismatch.engines.vocabulary import LINKAGE, WHEELS, Array
from studies.mismatch.engines.writing import Log, Robot

SUBSTEPS, LONGEST = 4, 0.005  # least substeps of a sample period, and their longest duration [s]
HOLD = 0.4  # [1/s], gain with which truck b keeps the link's length


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor, by how the distance of a wheel scatters on it."""

    roughness: float  # scatter of the distance [m/sqrt(m)]
    wave: float  # length over which the scatter is correlated [m]; 0 for none


def drive(
    robot: Robot, laps: list[Lap], faults: list[ConcealedFault], floor: Floor, start: float, chance: Generator
) -> Log:
    """Return one drive, from the time `start` [s], of a robot with faults; they keep their state after it."""
    wanted, spans = commands(laps, robot.period, robot.servo)
    engine = _Engine(robot, faults, floor, chance)
    count = len(wanted)
    shape = count, len(robot.devices)
    readings, scatter, poses = np.zeros(shape), np.zeros(shape), np.zeros((count, robot.trucks, 3))
    times = start + robot.period * np.arange(count, dtype=np.float64)
    for sample in range(count):
        if sample:
            engine.advance(wanted[sample], float(times[sample - 1]))
        readings[sample], poses[sample] = engine.read(), engine.pose
        scatter[sample] = robot.jitter * chance.normal(size=len(robot.devices))
    counts = [
        device.counted(readings[:, at], scatter[:, at] * (device.channel in LINKAGE))
        for at, device in enumerate(robot.devices)
    ]
    times_of = [(direction, float(times[first]), float(times[last])) for direction, first, last in spans]
    return Log(times, _aged(robot, np.stack(counts, axis=1), times, faults), poses, times_of)


class _Engine:
    def __init__(self, robot: Robot, faults: list[ConcealedFault], floor: Floor, chance: Generator) -> None:
        self.robot, self.faults, self.floor, self.chance = robot, faults, floor, chance
        self.pose = np.zeros((robot.trucks, 3))
        if robot.trucks == 2:
            self.pose[1] = (-robot.length, 0.0, 0.0)
        self.angle = chance.uniform(-3.0, 3.0, 2 * robot.trucks)
        self.counted = self.angle.copy()
        self.speed = np.zeros(2 * robot.trucks)
        self.patch = np.zeros(2 * robot.trucks)
        self.substeps = max(SUBSTEPS, math.ceil(robot.period / LONGEST - 1e-9))

    def advance(self, wanted: Array, now: float) -> None:
        span = self.robot.period / self.substeps
        robot = self.robot
        linkage = self._linkage() if robot.trucks == 2 else ()
        speed, turn = map(float, wanted)
        target = wheel_ways(robot.wheelbase, speed, turn, linkage, (robot.steady, HOLD, robot.length))
        rate = (target - self.speed) / self.robot.period
        for substep in range(self.substeps):
            self.speed = self.speed + rate * span
            self._step(rate, now + (substep + 1) * span, span)

    def _linkage(self) -> tuple[float, float, float]:
        gap = self.pose[0, :2] - self.pose[1, :2]
        along = math.atan2(gap[1], gap[0])
        joints = [math.remainder(self.pose[truck, 2] - along, 2.0 * math.pi) for truck in (0, 1)]
        return joints[0], joints[1], math.hypot(*gap)

    def _step(self, rate: Array, now: float, span: float) -> None:
        ways = np.zeros(2 * self.robot.trucks)
        for wheel in range(2 * self.robot.trucks):
            rolled = float(self.speed[wheel]) * span
            turn = rolled / self.robot.radius[wheel]
            before, after = float(self.counted[wheel]), float(self.counted[wheel]) + turn
            self.angle[wheel] += turn
            self.counted[wheel] += turn * self._kept(wheel)
            speeds = float(self.speed[wheel]), float(rate[wheel])
            place = self._place(wheel)
            step = WheelStep(rolled, (before, after), *speeds, now, span, WHEELS[wheel], place)
            way = rolled
            for fault in self.faults:
                if touches(fault, WHEELS[wheel]):
                    way += travelled(fault, step) - rolled
            ways[wheel] = way + self._scatter(wheel, abs(rolled))
        for fault in self.faults:
            felt(fault, float(0.5 * (rate[0] + rate[1])), span)
        for truck in range(self.robot.trucks):
            self._move(truck, ways[2 * truck], ways[2 * truck + 1], now, span)

    def _place(self, wheel: int) -> Place:
        """Return where a wheel is on the floor [m]."""
        x, y, heading = self.pose[wheel // 2]
        half = 0.5 * self.robot.wheelbase[wheel // 2] * (1.0 if wheel % 2 == 0 else -1.0)
        return float(x - half * math.sin(heading)), float(y + half * math.cos(heading))

    def _kept(self, wheel: int) -> float:
        """Return the share of a wheel's counts that its device counts."""
        for fault in self.faults:
            if fault.effect == "count_loss" and fault.component == WHEELS[wheel]:
                return float(counted_share(fault.parameters, self.speed[wheel]))
        return 1.0

    def _scatter(self, wheel: int, way: float) -> float:
        """Return what the floor adds to a distance [m]: correlated along its waves, or new in each step."""
        if way == 0.0:
            return 0.0
        if self.floor.wave == 0.0:
            return float(self.floor.roughness * math.sqrt(way) * self.chance.normal())
        kept = math.exp(-way / self.floor.wave)
        size = self.floor.roughness / math.sqrt(2.0 * self.floor.wave)
        self.patch[wheel] = (
            kept * self.patch[wheel] + size * math.sqrt(1.0 - kept * kept) * self.chance.normal()
        )
        return float(self.patch[wheel] * way)

    def _move(self, truck: int, left: float, right: float, now: float, span: float) -> None:
        base = self.robot.wheelbase[truck]
        twist = (0.5 * (left + right), 0.0, (right - left) / base)
        for fault in self.faults:
            if fault.component == "ab"[truck]:
                x, y, heading = map(float, self.pose[truck])
                twist = moved(fault, twist, TruckStep(base, (x, y), heading, now, span))
        middle = self.pose[truck, 2] + 0.5 * twist[2]
        self.pose[truck, 0] += twist[0] * math.cos(middle) - twist[1] * math.sin(middle)
        self.pose[truck, 1] += twist[0] * math.sin(middle) + twist[1] * math.cos(middle)
        self.pose[truck, 2] += twist[2]

    def read(self) -> list[float]:
        """Return the reading of every device [rad, m], the link's from its length at rest."""
        values = {WHEELS[number]: float(angle) for number, angle in enumerate(self.counted)}
        if self.robot.trucks == 2:
            true = dict(zip(LINKAGE, self._linkage(), strict=True))
            for channel, reading in true.items():
                other = true["joint_b" if channel == "joint_a" else "joint_a"]
                for fault in self.faults:
                    if fault.component == channel:
                        reading = shown(fault, reading, self.robot.length, true["joint_a"], other)  # noqa: PLW2901
                values[channel] = reading
            values["link"] -= self.robot.length
        return [values[channel] for channel in self.robot.channels]


def _aged(
    robot: Robot, counts: NDArray[np.int64], times: Array, faults: list[ConcealedFault]
) -> NDArray[np.int64]:
    """Return counts in which the samples of channels with latency or clock drift are older."""
    aged = counts.copy()
    for fault in faults:
        if fault.effect in {"latency", "clock_drift"} and fault.component in robot.channels:
            column = robot.channels.index(fault.component)
            aged[:, column] = np.round(of_age(counts[:, column], times, fault.parameters))
    return aged
