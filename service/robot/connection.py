"""The connection to the robot: its bus, opened by its URL, or a simulated robot in the same process."""

from __future__ import annotations

import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.robot.driver import Driver
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.truth import Truth, uncalibrated

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from omnimate.motion.drive import Fix
    from omnimate.service.robot.frame_feed import FrameFeed
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.se2 import Array


MAX_DELAY = 0.5  # [s] of host time; a longer delay is not caught up with


class PacedClock(SyncClock):
    """A clock whose SYNC number k has the time start + k * period, and that runs `pace` times as fast."""

    def __init__(self, period: float, start: float) -> None:
        super().__init__(period, start)
        self._pace = 1.0
        self._anchor()

    def _anchor(self) -> None:
        """Count the host's time from here on."""
        self._anchor_sync, self._anchor_time = self._next, time.monotonic()

    def set_pace(self, pace: float) -> None:
        """Let the clock's time pass `pace` times as fast as the host's from now on."""
        self._pace = pace
        self._anchor()

    def due(self) -> float:
        """Return the time until the next SYNC [s]; it is negative when the SYNC is late."""
        host_time = (self._next - self._anchor_sync) * self.period / self._pace
        wait = self._anchor_time + host_time - time.monotonic()
        if wait < -MAX_DELAY:
            self._anchor()
        return wait


TAPE_SIGMA = np.array([0.005, 0.005, 0.01])  # [m, m, rad], of a pose that a person measures


@dataclass(frozen=True, slots=True)
class RobotConnection:
    """A robot whose bus is open."""

    driver: Driver
    fix: Fix | None  # measures the absolute pose of a truck; None where only a person can
    clock: PacedClock | None  # of a simulated robot; None for a real one

    def set_pace(self, pace: float) -> None:
        """Let the time of a simulated robot pass `pace` times as fast as real time."""
        if self.clock is not None:
            self.clock.set_pace(pace)


@contextmanager
def connected(
    vehicle: VehicleParameters,
    bus: str | None,
    plant: Plant | None,
    frame_feed: FrameFeed,
    flight_recorder: Path | None,
) -> Iterator[RobotConnection]:
    """Open the robot's bus, configure its encoders (DriverError where not), and close it with the block."""
    clock = None if plant is None else PacedClock(vehicle.bus.sync_period, time.time())
    with ExitStack() as stack:
        opened = bus if plant is None else stack.enter_context(CoupledBus(vehicle, plant))
        assert opened is not None  # there is a bus or a plant
        driver = Driver(vehicle, opened, clock=clock, recorder=frame_feed, flight_recorder=flight_recorder)
        stack.enter_context(driver).configure()
        yield RobotConnection(driver, None if plant is None else _fix_of(plant), clock)


def simulated_plant(nominal: VehicleParameters) -> Plant:
    """Return a simulated robot with the errors of U Fig. 11 against its nominal parameters."""
    return Plant(Truth(uncalibrated(nominal), seed=1), nominal)


def _fix_of(plant: Plant) -> Fix:
    """Return the measurement of a simulated robot's pose: by sonar, or by tape without an echo."""

    def fix(truck: TruckName) -> tuple[Array, Array]:
        pose, sigma = plant.fix(truck)
        return (pose, sigma) if np.isfinite(pose).all() else (plant.pose(truck), TAPE_SIGMA)

    return fix
