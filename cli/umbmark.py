"""`omnimate umbmark`: return errors -> wheelbase and wheel diameters."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from calib.experiment import experiment_of_recordings
from calib.extended import extended_umbmark
from calib.profiles import save_profile
from calib.scale import scale_from_tape
from cli.console import out
from cli.loading import load
from cli.plots import Clusters, check_format, plot_clusters
from cli.umbmark_outputs import Format, calibrated_trucks, calibrated_vehicle, export
from cli.umbmark_results import heed, result_of
from cli.umbmark_sources import load_cases
from cli.umbmark_tables import METHOD_WORDS, calibration_table, errors_table, show
from cli.umbmark_words import all_passes, extended_words, say, show_worksheet, stop_rule, summary
from vehicle.file import load_vehicle, save_vehicle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cli.umbmark_results import Result
    from cli.umbmark_sources import Case
    from vehicle.parameters import TruckName, VehicleParameters


class TruckChoice(Enum):
    """Which truck to calibrate."""

    a = "a"
    b = "b"


class MethodChoice(Enum):
    """Whose result --out and --plot take."""

    exact = "exact"
    weighted = "weighted"
    heading = "heading"
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
    check: Annotated[
        bool, typer.Option("--check", help="Check my numbers: print every step, formula by formula.")
    ] = False,
    tape: Annotated[
        tuple[float, float] | None,
        typer.Option(help="A straight: MEASURED CALCULATED [m]; their ratio is E_s."),
    ] = None,
    previous: Annotated[
        Path | None,
        typer.Option(help="vehicle.toml before the first pass: print the factors of all passes together."),
    ] = None,
    bumps: Annotated[
        list[Path] | None,
        typer.Option(help="Recording of squares with bumps: the extended UMBmark.", exists=True),
    ] = None,
    profile: Annotated[
        tuple[Path, str] | None, typer.Option(help="FILE NAME: keep the result there under this name.")
    ] = None,
    export_as: Annotated[
        Format | None, typer.Option("--export", help="Print the result for others, and nothing else.")
    ] = None,
    wheel_width: Annotated[
        float | None, typer.Option(help="Width of a wheel [m]; VDA 5050 wants it.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Use a result that the checks refuse.")] = False,
) -> None:
    """Calibrate wheelbase and wheel diameters from squares driven cw and ccw (UMBmark)."""
    if plot is not None:
        check_format(plot)
    name: TruckName | None = truck.value if truck is not None else None
    cases, robot = load_cases(sources, name, side, load_vehicle(vehicle) if vehicle is not None else None)
    for case in cases if check else ():
        show_worksheet(case)
    e_s = 1.0 if tape is None else scale_from_tape([tape[0]], [tape[1]]).e_s
    results = [result_of(case, method.value, e_s) for case in cases]
    calibrated = calibrated_vehicle(results, robot) if out_file is not None else None
    if export_as is not None:
        text = export(export_as, results, robot, wheel_width)
        heed(cases, force=force)
        out.print(text, end="", soft_wrap=True)
    else:
        _report(results, e_s, load_vehicle(previous) if previous is not None else None)
        for folder in bumps or ():
            _extended(cases, folder, side)
        heed(cases, force=force)
    if plot is not None:
        plot_clusters([_panel(one) for one in results], plot)
        say(f"figure: {plot}")
    if out_file is not None and calibrated is not None:
        save_vehicle(calibrated, out_file)
        say(f"calibrated ({METHOD_WORDS[method.value]}): {out_file}")
    if profile is not None:
        save_profile(profile[0], profile[1], calibrated_trucks(results))
        say(f"profile {profile[1]}: {profile[0]}")


def _report(results: Sequence[Result], e_s: float, before: VehicleParameters | None) -> None:
    """Print the tables and the sentences; `before` is the robot before its first pass."""
    cases = [one.case for one in results]
    show(errors_table(cases))
    show(calibration_table(cases, [one.calibrations for one in results]))
    for one in results:
        for line in summary(one.case, one.chosen):
            say(line)
        say(f"  {stop_rule(one.case.experiment.errors)}")
        if before is not None and one.case.truck in before.trucks:
            say(f"  {all_passes(before.trucks[one.case.truck], one.truck)}")
    if e_s != 1.0:
        say(f"E_s {e_s:.5f} by tape: wheels and wheelbase are written {e_s:.5f} times as large")


def _extended(cases: Sequence[Case], folder: Path, side: float | None) -> None:
    """Print the extended UMBmark: the squares of each truck against those of a recording with bumps."""
    for case in cases:
        smooth = case.experiment.errors
        bumpy = experiment_of_recordings([load(folder)], case.truck, side).errors
        result = extended_umbmark(smooth.cw[:, 2], smooth.ccw[:, 2], bumpy.cw[:, 2], bumpy.ccw[:, 2])
        say(f"{case.label}: {extended_words(result)}")


def _panel(one: Result) -> Clusters:
    return Clusters(one.case.label, one.case.experiment.errors, one.chosen.errors)
