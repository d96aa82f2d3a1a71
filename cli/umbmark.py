"""`omnimate umbmark`: return errors -> wheelbase and wheel diameters."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from calib.experiment import Calibration, calibrate, usable_methods
from cli.console import out
from cli.plots import Clusters, check_format, plot_clusters
from cli.umbmark_sources import Case, load_cases
from cli.umbmark_tables import METHOD_WORDS, calibration_table, errors_table, show, stop_rule
from vehicle.file import load_vehicle, save_vehicle

if TYPE_CHECKING:
    from calib.umbmark import Method
    from vehicle.parameters import Truck, TruckName, VehicleParameters


class TruckChoice(Enum):
    """Which truck to calibrate."""

    a = "a"
    b = "b"


class MethodChoice(Enum):
    """Whose result --out and --plot take."""

    exact = "exact"
    printed = "printed"


def umbmark(
    sources: Annotated[
        list[Path],
        typer.Argument(
            help="Recording folders, a CSV table of return errors, or OptiOdom folders.", exists=True
        ),
    ],
    truck: Annotated[
        TruckChoice | None, typer.Option(help="Calibrate this truck only; else each one that has fixes.")
    ] = None,
    side: Annotated[float | None, typer.Option(help="Side of the square [m]; a table needs it.")] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(help="vehicle.toml that the odometry was calculated with; a table needs it."),
    ] = None,
    out_file: Annotated[
        Path | None, typer.Option("--out", help="Write the calibrated vehicle.toml here.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the return errors before and after: .png, .svg or .pdf.")
    ] = None,
    method: Annotated[
        MethodChoice, typer.Option(help="Whose result --out and --plot take.")
    ] = MethodChoice.exact,
) -> None:
    """Calibrate wheelbase and wheel diameters from squares driven cw and ccw (UMBmark)."""
    if plot is not None:
        check_format(plot)
    name: TruckName | None = truck.value if truck is not None else None
    cases, robot = load_cases(sources, name, side, load_vehicle(vehicle) if vehicle is not None else None)
    calibrations = [
        [calibrate(case.experiment, one) for one in usable_methods(case.experiment.errors)] for case in cases
    ]
    kept: Method = method.value
    chosen = [next(one for one in row if one.correction.method == kept) for row in calibrations]
    calibrated = _calibrated(cases, chosen, robot) if out_file is not None else None
    show(errors_table(cases))
    show(calibration_table(cases, calibrations))
    for case in cases:
        out.print(f"{case.label}: {stop_rule(case.experiment.errors)}", soft_wrap=True)
    if plot is not None:
        plot_clusters([_panel(case, one) for case, one in zip(cases, chosen, strict=True)], plot)
        out.print(f"figure: {plot}", soft_wrap=True)
    if out_file is not None and calibrated is not None:
        save_vehicle(calibrated, out_file)
        out.print(f"calibrated ({METHOD_WORDS[kept]}): {out_file}", soft_wrap=True)


def _calibrated(
    cases: list[Case], chosen: list[Calibration], robot: VehicleParameters | None
) -> VehicleParameters:
    """Return the robot with its calibrated trucks.

    Raises:
        CalibrationError: the robot is not known, or two experiments want the same truck.
    """
    if robot is None:
        raise CalibrationError(
            cases[0].experiment.source, "it holds no vehicle.toml to calibrate: give --vehicle vehicle.toml"
        )
    trucks: dict[TruckName, Truck] = {}
    for case, calibration in zip(cases, chosen, strict=True):
        if case.truck in trucks:
            raise CalibrationError(
                case.experiment.source,
                f"a second experiment for truck {case.truck}; --out takes one for each",
            )
        trucks[case.truck] = calibration.truck
    return corrected_vehicle(robot, trucks)


def _panel(case: Case, calibration: Calibration) -> Clusters:
    return Clusters(case.label, case.experiment.errors, calibration.errors)
