"""A simulated robot on a bus of this process, with the real driver reading it."""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from driver.clock import SyncClock
from driver.driver import Driver
from driver.recorder import Recorder
from vcan_sim.lockstep import LockstepBus, QuickBus
from vcan_sim.plant import Plant
from vcan_sim.simulated_vehicle import SimulatedVehicle

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from motion.program import Program
    from vcan_sim.faults import Fault
    from vcan_sim.truth import Truth
    from vehicle.parameters import VehicleParameters

_channels = count()


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
    faults: Iterable[Fault] = (),
) -> Iterator[SimulatedRobot]:
    """Open a virtual bus with a simulated vehicle on it and the driver, as fast as it goes.

    Args:
        vehicle: as its owner believes it to be.
        truth: as it is.
        folder: of the recording.
        program: whose protocol and side stand in `run.toml`.
        faults: of the devices.
    """
    channel = f"omnimate-{next(_channels)}"
    plant = Plant(truth, vehicle)
    with (
        QuickBus(channel) as theirs,
        LockstepBus(channel) as ours,
        Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder,
    ):
        simulated = SimulatedVehicle(vehicle, plant, theirs, faults=faults)
        ours.answer = simulated.poll
        clock = SyncClock(vehicle.bus.sync_period)
        with Driver(vehicle, ours, clock=clock, recorder=recorder) as driver:
            yield SimulatedRobot(driver, recorder, plant)
