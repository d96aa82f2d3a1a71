"""The robot's bus, opened: a real one by its URL, or a simulated robot in this process."""

from __future__ import annotations

import time
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from driver.driver import Driver
from service.robot.pace import PacedClock
from vcan_sim.coupled_bus import CoupledBus
from vcan_sim.plant import Plant
from vcan_sim.truth import Truth, uncalibrated

BY_TAPE = np.array([0.005, 0.005, 0.01])  # [m, m, rad], standard deviations

if TYPE_CHECKING:
    from collections.abc import Iterator

    from motion.drive import Fix
    from service.robot.tap import Tap
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Rig:
    """What the robot's thread works with.

    Attributes:
        driver: reads and commands, through the bus alone.
        fix: measures absolute poses; None where only people can.
        clock: of a simulated robot, whose pace may be changed.
    """

    driver: Driver
    fix: Fix | None = None
    clock: PacedClock | None = None

    def pace(self, pace: float) -> None:
        """Let a simulated robot's time pass so many times as fast as ours."""
        if self.clock is not None:
            self.clock.pace = pace


def simulated_plant(nominal: VehicleParameters) -> Plant:
    """Return a robot as it truly is: with the errors of U Fig. 11 against its nominal parameters."""
    return Plant(Truth(uncalibrated(nominal), seed=1), nominal)


def _measured(plant: Plant) -> Fix:
    """Return what measures a simulated robot: its sonar, or a person with a tape where no wall is seen."""

    def fix(truck: TruckName) -> tuple[Array, Array]:
        pose, sigma = plant.fix(truck)
        return (pose, sigma) if np.isfinite(pose).all() else (plant.pose(truck), BY_TAPE)

    return fix


@contextmanager
def opened(vehicle: VehicleParameters, bus: str | None, plant: Plant | None, tap: Tap) -> Iterator[Rig]:
    """Open the robot's bus with the driver on it, configured and ready for samples.

    Args:
        vehicle: as its owner believes it to be.
        bus: URL of a real one.
        plant: of the simulated robot in its place.
        tap: gets every frame.

    Raises:
        DriverError: the bus cannot be opened, or a node is not as it must be.
    """
    if plant is None:
        assert bus is not None  # one or the other
        with Driver(vehicle, bus, recorder=tap) as driver:
            driver.configure()
            yield Rig(driver)
        return
    clock = PacedClock(vehicle.bus.sync_period, time.time())
    with (
        CoupledBus(vehicle, plant) as coupled,
        Driver(vehicle, coupled, clock=clock, recorder=tap) as driver,
    ):
        driver.configure()
        yield Rig(driver, _measured(plant), clock)
