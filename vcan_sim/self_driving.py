"""A simulated robot that drives by itself: its own odometry, a program, and the sonar at its stops."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.motion.journal import Journal
from omnimate.motion.reading import LinkReader
from omnimate.motion.runner import Runner
from omnimate.vehicle.counters import counter_law, counters_of, take_readings
from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.sample import Sample

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.motion.program import Program
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vehicle.parameters import VehicleParameters


class SelfDriving:
    """Gives wheel speeds in the drives' place, SYNC by SYNC; when the program is done the robot stands.

    Attributes:
        journal: Laps and fixes so far, on the clock given.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        program: Program,
        clock: Callable[[], float],
        on_fix: Callable[[Journal], None] = lambda _journal: None,
    ) -> None:
        """Begin a program where the plant stands.

        Args:
            vehicle: Robot as its owner believes it to be.
            plant: Plant that the wheel speeds move.
            program: Program to drive.
            clock: Clock of the journal [s].
            on_fix: Function that is called after each absolute fix.
        """
        self.journal = Journal(program)
        self._plant, self._clock, self._on_fix = plant, clock, on_fix
        self._trucks = tuple(vehicle.trucks)
        self._counters = counters_of([counter_law(encoder, vehicle) for encoder in vehicle.encoders])
        self._odometer, self._link = Odometer(vehicle, "a"), LinkReader(vehicle)
        self._runner = Runner(program, vehicle)
        self._standing = (0.0,) * len(vehicle.wheels)
        self._steps = 0

    def __call__(self, _simulated: object) -> Sequence[float]:
        """Return the wheel speeds [rad/s] until the next SYNC."""
        if self._runner.done:
            return self._standing
        now = self._clock()
        sample = self._read(now)
        speeds = self._runner.step(self._odometer.step(sample), self._link.read(sample.counts))
        lap = self.journal.lap
        self.journal.observe(now, self._runner)
        if self.journal.lap != lap:
            self._plant.begin_lap(self.journal.lap)
        if self._runner.fix_due:
            self._take_fixes(now)
        return speeds

    def _read(self, now: float) -> Sample:
        take_readings(self._counters, np.array(self._plant.raw_counts(), np.int64))
        counts = tuple(self._counters["count"].tolist())
        unknown = (math.nan,) * len(counts)
        self._steps += 1
        return Sample(
            self._steps - 1, now, counts, tuple(self._counters["present"].tolist()), unknown, unknown
        )

    def _take_fixes(self, now: float) -> None:
        for truck in self._trucks:
            pose, sigma = self._plant.fix(truck)
            self.journal.fix(now, truck, pose, sigma)
            if truck == "a" and all(map(math.isfinite, pose)):
                self._odometer.pose = (float(pose[0]), float(pose[1]), float(pose[2]))
        self._on_fix(self.journal)
