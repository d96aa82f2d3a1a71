"""The drives of the demo: UMBmark on a virtual bus by the real driver; its table and its figures."""

from __future__ import annotations

import shutil
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.cli.console import out, warn
from omnimate.cli.driver_reports import show_configuration, show_report
from omnimate.cli.driving import drive_program
from omnimate.cli.tables import new_table
from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rich.table import Table

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.motion.drive import Moment
    from omnimate.motion.program import Program
    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True)
class Settings:
    """What is driven.

    Attributes:
        side: Side of the square [m].
        runs: Squares in each direction.
        speed: Speed of the wheels [m/s].
    """

    side: float
    runs: int
    speed: float


def drive(
    vehicle: VehicleParameters,
    truth: Truth,
    settings: Settings,
    folder: Path,
    faults: tuple[DeviceFault, ...] = (),
) -> tuple[Recording, Array]:
    """Drive UMBmark on a virtual bus; return the recording and the true path of truck a `(N, 3)`."""
    assert vehicle.linkage is not None  # the reference vehicle has two trucks
    program = umbmark(settings.side, settings.runs, speed=settings.speed, link_length=vehicle.linkage.length)
    if folder.exists():
        shutil.rmtree(folder)
    with simulated_robot(vehicle, truth, folder, program, faults) as robot:
        configured = robot.driver.configure()
        if vehicle.trucks == reference_vehicle().trucks:
            show_configuration(configured)
        else:
            out.print(f"  {len(configured.nodes)} encoders found and configured as before")
        path = _TruePath(robot.plant)
        drive_program(robot.driver, program, robot.recorder, robot.plant.fix, path.watch)
        show_report(robot.driver.report())
    return load_recording(folder), path.poses


class _TruePath:
    """The true path of truck a over the first square in each direction."""

    EVERY = 10  # samples

    def __init__(self, plant: Plant) -> None:
        self._plant, self._count = plant, 0
        self._poses: list[Array] = []

    def watch(self, moment: Moment) -> None:
        """Record the true pose at a moment of the drive."""
        self._count += 1
        if moment.lap in {0, 1} and self._count % self.EVERY == 0:
            self._poses.append(self._plant.pose("a"))

    @property
    def poses(self) -> Array:
        """The path so far, `(N, 3)`."""
        return np.array(self._poses)


@dataclass(frozen=True)
class SimulatedRobot:
    """The simulated vehicle and its driver, on both sides of a virtual bus.

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
        vehicle: as vehicle.toml describes it.
        truth: as it is.
        folder: of the recording.
        program: whose protocol and side stand in `run.toml`.
        faults: Faults of the devices.
    """
    plant = Plant(truth, vehicle)
    with (
        CoupledBus(vehicle, plant, faults) as bus,
        Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder,
        Driver(vehicle, bus, clock=SyncClock(vehicle.bus.sync_period), recorder=recorder) as driver,
    ):
        yield SimulatedRobot(driver, recorder, plant)


def result_table(
    before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], truth: Truth
) -> Table:
    """Return the table of E_max,syst before and after, and of fitted and true parameters."""
    errors = ("E_max,syst before", "after", "better by")
    parameters = ("wheelbase nominal", "found", "true", "D_R/D_L found", "true")
    table = new_table("UMBmark before and after: millimetres", ("truck",), (*errors, *parameters))
    for truck, calibration in before.items():
        first, second = calibration.experiment.errors.e_max_syst, after[truck].experiment.errors.e_max_syst
        fitted, true = calibration.truck, truth.vehicle.trucks[truck]
        table.add_row(
            truck,
            f"{1e3 * first:.0f}",
            f"{1e3 * second:.0f}",
            f"{first / second:.1f}-fold",
            f"{1e3 * calibration.experiment.truck.wheelbase:.2f}",
            f"{1e3 * fitted.wheelbase:.2f}",
            f"{1e3 * true.wheelbase:.2f}",
            f"{fitted.wheel_diameter_right / fitted.wheel_diameter_left:.5f}",
            f"{true.wheel_diameter_right / true.wheel_diameter_left:.5f}",
        )
    return table


def draw_clusters(
    before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], path: Path
) -> None:
    """Draw the return errors before and after, as U Fig. 11."""
    from omnimate.figures.clusters import Clusters, plot_clusters

    plot_clusters(
        [
            Clusters(f"truck {truck}", before[truck].experiment.errors, after[truck].experiment.errors)
            for truck in before
        ],
        path,
    )


def draw_paths(recording: Recording, true_path: Array, path: Path) -> None:
    """Draw the first square in each direction: the true path, and odometry from each lap's first fix."""
    from omnimate.figures.floor_plan import Track, plot_floor_plan

    if recording.run is None or recording.poses is None or len(true_path) == 0:
        warn("no lap was driven to its end; no path is drawn")
        return
    fixes = recording.poses.of("a")
    pose = dead_reckon(recording, "a")
    tracks = [Track("truck a, true", true_path)]
    for lap in recording.run.laps[:2]:
        driven = pose[recording.between(lap.start, lap.end)]
        fix = fixes.pose[np.searchsorted(fixes.time, lap.start, side="right") - 1]
        tracks.append(
            Track(f"truck a by odometry, {lap.direction}", compose(fix, between(driven[0], driven)))
        )
    plot_floor_plan(tracks, path, title="before calibration", fixes=fixes.pose[:4])
