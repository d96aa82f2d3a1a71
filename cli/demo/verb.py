"""`omnimate demo`: a simulated OmniMate drives UMBmark on a virtual bus, is calibrated, and drives again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import out, say
from omnimate.cli.robots import program_of, truth_of

if TYPE_CHECKING:
    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Recording

SEED_STEP = 1000  # from the first drive to the second, which has other random numbers


def demo(
    folder: Annotated[
        Path, typer.Option("--out", help="Folder for recordings, vehicle.toml and figures.")
    ] = Path("demo-out"),
    side: Annotated[float, typer.Option(help="Side of the square [m].", min=0.5, max=20.0)] = 4.0,
    runs: Annotated[int, typer.Option(help="Squares in each direction.", min=1, max=50)] = 5,
    speed: Annotated[float, typer.Option(help="Speed of the wheels [m/s].", min=0.05, max=0.5)] = 0.4,
    seed: Annotated[
        int, typer.Option(help="Seed of the floor's roughness and the sonar's noise.", min=0)
    ] = 1,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            help="Fault of a device in the first drive, such as reboot:node=2,at=30; may be repeated."
        ),
    ] = None,
) -> None:
    """Drive UMBmark with a simulated robot on a virtual bus, calibrate it, drive again."""
    from omnimate.cli.demo.drive import draw_paths, drive, result_table
    from omnimate.cli.tables import show
    from omnimate.figures.clusters import Clusters, plot_clusters
    from omnimate.vcan_sim.faults import parse_fault
    from omnimate.vcan_sim.reference import reference_vehicle

    faults = tuple(parse_fault(text) for text in fault or ())
    nominal = reference_vehicle()
    truth = truth_of(nominal, None, (), seed)
    second_day = replace(truth, seed=seed + SEED_STEP)
    folder.mkdir(parents=True, exist_ok=True)
    program = program_of("umbmark", nominal, side=side, runs=runs, speed=speed)
    _introduce(nominal, side, runs, speed)
    out.rule("1  the robot with its nominal vehicle.toml", align="left")
    before, path = drive(nominal, truth, program, folder / "before", faults)
    calibrations = _calibrations(before)
    calibrated = _save(nominal, calibrations, folder / "vehicle.toml")
    out.rule("2  the same robot, calibrated", align="left")
    after, _ = drive(calibrated, second_day, program, folder / "after")
    again = _calibrations(after)
    out.rule("result", align="left")
    show(result_table(calibrations, again, truth))
    panels = [
        Clusters(f"truck {truck}", first.experiment.errors, again[truck].experiment.errors)
        for truck, first in calibrations.items()
    ]
    plot_clusters(panels, folder / "umbmark.png")
    draw_paths(before, path, folder / "path.png")
    for name, what in (
        ("before/ and after/", "the two recordings: candump log, fixes, laps, vehicle.toml"),
        ("vehicle.toml", "the calibrated robot"),
        ("umbmark.png", "return errors before and after, as U Fig. 11"),
        ("path.png", "one square in each direction: true path and odometry"),
    ):
        say(f"  {folder}/{name:<20} {what}")


def _introduce(vehicle: VehicleParameters, side: float, runs: int, speed: float) -> None:
    """Print the introduction."""
    say(
        f"A simulated {vehicle.name} on a virtual CAN bus: two trucks on a compliant linkage, "
        f"{len(vehicle.encoders)} CANopen encoders, {len(vehicle.drives)} drives.\n"
        f"UMBmark, {side:g} m squares, {runs} in each direction at {speed:g} m/s, "
        "read and driven through the bus alone.\nIts wheelbases and wheels differ from vehicle.toml; the "
        "return errors give by how much. Then once more, calibrated.\n"
    )


def _calibrations(recording: Recording) -> dict[TruckName, Calibration]:
    from omnimate.calib.umbmark.experiment import calibrate, experiment_of_recordings

    return {
        truck: calibrate(experiment_of_recordings([recording], truck)) for truck in recording.vehicle.trucks
    }


def _save(
    vehicle: VehicleParameters, calibrations: dict[TruckName, Calibration], path: Path
) -> VehicleParameters:
    from omnimate.calib.apply import corrected_vehicle
    from omnimate.vehicle.file import save_vehicle

    trucks = {name: calibration.truck for name, calibration in calibrations.items()}
    calibrated = corrected_vehicle(vehicle, trucks)
    save_vehicle(calibrated, path)
    return calibrated
