"""`omnimate umbmark`: return errors -> wheelbase and wheel diameters."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cli.choices import Format, MethodChoice, TruckChoice
from cli.console import out

if TYPE_CHECKING:
    from vehicle.parameters import TruckName


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
    from calib.profiles import save_profile
    from calib.scale import scale_from_tape
    from cli.umbmark_outputs import calibrated_trucks, calibrated_vehicle, export
    from cli.umbmark_report import extended, panel, report
    from cli.umbmark_results import heed, result_of
    from cli.umbmark_sources import load_cases
    from cli.umbmark_tables import METHOD_WORDS
    from cli.umbmark_words import say, show_worksheet
    from figures.plots import check_format, plot_clusters
    from vehicle.file import load_vehicle, save_vehicle

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
        report(results, e_s, load_vehicle(previous) if previous is not None else None)
        for folder in bumps or ():
            extended(cases, folder, side)
        heed(cases, force=force)
    if plot is not None:
        plot_clusters([panel(one) for one in results], plot)
        say(f"figure: {plot}")
    if out_file is not None and calibrated is not None:
        save_vehicle(calibrated, out_file)
        say(f"calibrated ({METHOD_WORDS[method.value]}): {out_file}")
    if profile is not None:
        save_profile(profile[0], profile[1], calibrated_trucks(results))
        say(f"profile {profile[1]}: {profile[0]}")
