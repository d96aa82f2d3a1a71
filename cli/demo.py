"""`omnimate demo`: a simulated OmniMate drives UMBmark on a virtual bus, is calibrated, and drives again."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.table import Table

from cli.console import out, warn
from cli.robots import truth_of

if TYPE_CHECKING:
    from calib.experiment import Calibration
    from motion.drive import Moment
    from vcan_sim.faults import Fault
    from vcan_sim.plant import Plant
    from vcan_sim.truth import Truth
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.recording import Recording
    from vehicle.se2 import Array


OTHER_CHANCE = 1000  # added to the seed, so that the second drive meets another roughness of the floor


@dataclass(frozen=True)
class Settings:
    """What is driven.

    Attributes:
        side: of the square [m].
        runs: in each direction.
        speed: [m/s].
    """

    side: float
    runs: int
    speed: float


def demo(
    folder: Annotated[
        Path, typer.Option("--out", help="Folder for recordings, vehicle.toml and figures.")
    ] = Path("demo-out"),
    side: Annotated[float, typer.Option(help="Side of the square [m].", min=0.5, max=20.0)] = 4.0,
    runs: Annotated[int, typer.Option(help="Squares in each direction.", min=1, max=50)] = 5,
    speed: Annotated[float, typer.Option(help="Of the wheels [m/s].", min=0.05, max=0.5)] = 0.4,
    seed: Annotated[int, typer.Option(help="Of the floor's roughness and the sonar's noise.", min=0)] = 1,
    fault: Annotated[
        list[str] | None,
        typer.Option(help="Of a device in the first drive, such as reboot:node=2,at=30; may be repeated."),
    ] = None,
) -> None:
    """Drive UMBmark with a simulated OmniMate on a virtual CAN bus, calibrate it, and drive again."""
    from cli.umbmark_tables import show
    from vcan_sim.faults import parse_fault
    from vcan_sim.reference import reference_vehicle

    settings = Settings(side, runs, speed)
    faults = tuple(parse_fault(text) for text in fault or ())
    nominal = reference_vehicle()
    truth = truth_of(nominal, None, (), seed)
    another_day = replace(truth, seed=seed + OTHER_CHANCE)
    folder.mkdir(parents=True, exist_ok=True)
    _introduce(nominal, settings)
    out.rule("1  the robot as its owner believes it to be", align="left")
    before, path = _drive(nominal, truth, settings, folder / "before", faults)
    calibrations = _calibrations(before)
    calibrated = _save(nominal, calibrations, folder / "vehicle.toml")
    out.rule("2  the same robot, calibrated", align="left")
    after, _ = _drive(calibrated, another_day, settings, folder / "after")
    again = _calibrations(after)
    out.rule("result", align="left")
    show(result_table(calibrations, again, truth))
    _draw(calibrations, again, folder / "umbmark.png")
    _draw_paths(before, path, folder / "path.png")
    for name, what in (
        ("before/ and after/", "the two recordings: candump log, fixes, laps, vehicle.toml"),
        ("vehicle.toml", "the calibrated robot"),
        ("umbmark.png", "return errors before and after, as U Fig. 11"),
        ("path.png", "one square each way: where it went, and where it believed to be"),
    ):
        out.print(f"  {folder}/{name:<20} {what}", soft_wrap=True)


def _introduce(vehicle: VehicleParameters, settings: Settings) -> None:
    """Say what is about to be seen."""
    out.print(
        f"A simulated {vehicle.name} on a virtual CAN bus: two trucks on a compliant linkage, "
        f"{len(vehicle.encoders)} CANopen encoders, {len(vehicle.drives)} drives.\n"
        f"UMBmark, {settings.side:g} m squares, {settings.runs} each way at {settings.speed:g} m/s, read and "
        "driven through the bus alone. Its wheelbases and\nwheels are not what vehicle.toml says: the return "
        "errors tell by how much. Then once more, calibrated.\n",
        soft_wrap=True,
    )


def _drive(
    vehicle: VehicleParameters, truth: Truth, settings: Settings, folder: Path, faults: tuple[Fault, ...] = ()
) -> tuple[Recording, Array]:
    """Drive UMBmark on a virtual bus; return the recording and the true path of truck a `(N, 3)`."""
    from cli.driving import drive_program
    from cli.reports import show_configuration, show_report
    from cli.simulated import simulated_robot
    from motion.paths import umbmark
    from vcan_sim.reference import reference_vehicle
    from vehicle.folder import load_recording

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
    """The true path of truck a over the first square each way."""

    EVERY = 10  # samples

    def __init__(self, plant: Plant) -> None:
        self._plant, self._count = plant, 0
        self._poses: list[Array] = []

    def watch(self, moment: Moment) -> None:
        """Look at a moment of the drive."""
        self._count += 1
        if moment.lap in {0, 1} and self._count % self.EVERY == 0:
            self._poses.append(self._plant.pose("a"))

    @property
    def poses(self) -> Array:
        """The path so far, `(N, 3)`."""
        return np.array(self._poses)


def _calibrations(recording: Recording) -> dict[TruckName, Calibration]:
    from calib.experiment import calibrate, experiment_of_recordings

    return {
        truck: calibrate(experiment_of_recordings([recording], truck)) for truck in recording.vehicle.trucks
    }


def _save(
    vehicle: VehicleParameters, calibrations: dict[TruckName, Calibration], path: Path
) -> VehicleParameters:
    from calib.apply import corrected_vehicle
    from vehicle.file import save_vehicle

    calibrated = corrected_vehicle(vehicle, {truck: one.truck for truck, one in calibrations.items()})
    save_vehicle(calibrated, path)
    return calibrated


def result_table(
    before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], truth: Truth
) -> Table:
    """Return the table of E_max,syst before and after, and of what was found beside what is true."""
    table = Table(title="UMBmark before and after: millimetres", title_justify="left")
    for head in ("truck", "E_max,syst before", "after", "better by", "wheelbase nominal", "found", "true"):
        table.add_column(head, justify="right")
    table.add_column("D_R/D_L found", justify="right")
    table.add_column("true", justify="right")
    for truck, calibration in before.items():
        first, second = calibration.experiment.errors.e_max_syst, after[truck].experiment.errors.e_max_syst
        found, true = calibration.truck, truth.vehicle.trucks[truck]
        table.add_row(
            truck,
            f"{1e3 * first:.0f}",
            f"{1e3 * second:.0f}",
            f"{first / second:.1f}-fold",
            f"{1e3 * calibration.experiment.truck.wheelbase:.2f}",
            f"{1e3 * found.wheelbase:.2f}",
            f"{1e3 * true.wheelbase:.2f}",
            f"{found.wheel_diameter_right / found.wheel_diameter_left:.5f}",
            f"{true.wheel_diameter_right / true.wheel_diameter_left:.5f}",
        )
    return table


def _draw(before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], path: Path) -> None:
    from figures.plots import Clusters, plot_clusters

    plot_clusters(
        [
            Clusters(f"truck {truck}", before[truck].experiment.errors, after[truck].experiment.errors)
            for truck in before
        ],
        path,
    )


def _draw_paths(recording: Recording, true_path: Array, path: Path) -> None:
    """Draw the first square each way: the true path, and odometry's from the fix at each lap's start."""
    from figures.plots import Track, plot_floor_plan
    from vehicle.odometry import dead_reckon
    from vehicle.se2 import between, compose

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
