"""A simulated robot that drives a program by its odometry, with sonar poses at its stops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.motion.journal import Journal
from omnimate.motion.runner import Runner
from omnimate.vcan_sim.onboard import odometry_of, update_odometry

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.motion.program import Program
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vehicle.parameters import VehicleParameters


class SelfDriving:
    """Source of wheel speeds for each SYNC, in place of the drives; 0 after the end of the program.

    The `journal` has laps and measured poses so far, with times of `clock`.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        program: Program,
        clock: Callable[[], float] = lambda: 0.0,
        on_fix: Callable[[Journal], None] = lambda _journal: None,
    ) -> None:
        """Begin a program at the current pose of the plant, with the clock of the journal [s].

        `on_fix` is called after each absolute fix.
        """
        self.journal = Journal(program)
        self.runner = Runner(program, vehicle)
        self.odometry = odometry_of(vehicle)
        self._plant, self._clock, self._on_fix = plant, clock, on_fix
        self._vehicle = vehicle

    def __call__(self) -> Sequence[float]:
        """Return the wheel speeds [rad/s] until the next SYNC."""
        if self.runner.done:
            return (0.0,) * len(self._vehicle.wheels)
        now = self._clock()
        speeds = self.runner.step(*update_odometry(self.odometry[0], self._plant.state["counts"][0]))
        self.update(now)
        return speeds

    def update(self, now: float) -> None:
        """Update the journal at a time [s]; if a fix is due, set odometry to a measured pose, U III-C 1)."""
        lap = self.journal.lap
        self.journal.observe(now, self.runner)
        if self.journal.lap != lap:
            self._plant.begin_lap(self.journal.lap)
        if not self.runner.fix_due:
            return
        for truck in self._vehicle.trucks:
            pose, sigma = self._plant.fix(truck)
            self.journal.fix(now, truck, pose, sigma)
            if truck == "a" and np.all(np.isfinite(pose)):
                self.odometry["pose"] = pose
        self._on_fix(self.journal)
