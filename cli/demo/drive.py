"""The drives of the demo: UMBmark on a virtual bus by the real driver; its table and its figures."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from omnimate.cli.console import out, warn
from omnimate.cli.driver_reports import show_configuration, show_report
from omnimate.cli.driving import drive_program
from omnimate.cli.tables import new_table
from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording, remove_recording
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

TRUE_PATH_EVERY = 10  # steps between two points of the true path: 150 ms, 6 cm at 0.4 m/s


def drive(
    vehicle: VehicleParameters,
    truth: Truth,
    program: Program,
    folder: Path,
    faults: tuple[DeviceFault, ...] = (),
) -> tuple[Recording, Array]:
    """Drive a program on a virtual bus; return the recording and the true path of truck a `(N, 3)`."""
    remove_recording(folder)
    with simulated_robot(vehicle, truth, folder, program, faults) as (driver, recorder, plant):
        configured = driver.configure()
        if vehicle.trucks == reference_vehicle().trucks:
            show_configuration(configured)
        else:
            out.print(f"  {len(configured.nodes)} encoders found and configured as before")
        true_path: list[Array] = []

        def record_pose(moment: Moment) -> None:
            """Record the true pose of truck a in the first square of each direction."""
            if moment.lap in {0, 1} and plant.state["steps"][0] % TRUE_PATH_EVERY == 0:
                true_path.append(plant.pose("a"))

        drive_program(driver, program, recorder, plant.fix, record_pose)
        show_report(driver.report())
    return load_recording(folder), np.array(true_path)


@contextmanager
def simulated_robot(
    vehicle: VehicleParameters,
    truth: Truth,
    folder: Path,
    program: Program,
    faults: Iterable[DeviceFault] = (),
) -> Iterator[tuple[Driver, Recorder, Plant]]:
    """Open a virtual bus with a simulated vehicle and a driver; give driver, recorder and plant.

    `run.toml` of the recording gets the program's protocol and side.
    """
    plant = Plant(truth, vehicle)
    with (
        CoupledBus(vehicle, plant, faults) as bus,
        Recorder(folder, vehicle, protocol=program.protocol, side=program.side) as recorder,
        Driver(vehicle, bus, clock=SyncClock(vehicle.bus.sync_period), recorder=recorder) as driver,
    ):
        yield driver, recorder, plant


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
