"""A simulated robot on a bus of this process, with the real driver reading it."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.recorder import Recorder
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.plant import Plant

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from omnimate.motion.program import Program
    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import VehicleParameters


@dataclass(frozen=True)
class SimulatedRobot:
    """What stands on both sides of the bus.

    Attributes:
        driver: reads and commands, through the bus alone.
        recorder: gets every frame.
        plant: is asked for absolute fixes, as the sonar calibrator would be.
    """

    driver: Driver
    recorder: Recorder
    plant: Plant


@contextmanager
def simulated_robot(
    vehicle: VehicleParameters,
    truth: Truth,
    folder: Path,
    program: Program,
    faults: Iterable[DeviceFault] = (),
) -> Iterator[SimulatedRobot]:
    """Open a virtual bus with a simulated vehicle on it and the driver, as fast as they go.

    Args:
        vehicle: as its owner believes it to be.
        truth: as it is.
        folder: of the recording.
        program: whose protocol and side stand in `run.toml`.
        faults: of the devices.
    """
    plant = Plant(truth, vehicle)
    with (
        CoupledBus(vehicle, plant, faults) as bus,
        Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder,
        Driver(vehicle, bus, clock=SyncClock(vehicle.bus.sync_period), recorder=recorder) as driver,
    ):
        yield SimulatedRobot(driver, recorder, plant)
