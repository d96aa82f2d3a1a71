"""`omnimate umbmark`: return errors -> wheelbase and wheel diameters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import out
from omnimate.cli.descriptions import vehicle_of
from omnimate.cli.options import (
    ExportFormat,
    MethodChoice,
    OneTruck,
    OutFile,
    Profile,
    check_number,
    written_at_end,
)
from omnimate.cli.robots import write_profile, write_vehicle


def umbmark(
    sources: Annotated[
        list[Path],
        typer.Argument(help="Recording folders, or a CSV table of return errors.", exists=True),
    ],
    truck: OneTruck = None,
    side: Annotated[
        float | None,
        typer.Option(
            help="Side of the square [m]; a table needs it.", min=0.5, max=100.0, callback=check_number
        ),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(
            exists=True, help="vehicle.toml that the odometry was calculated with; a table needs it."
        ),
    ] = None,
    out_file: OutFile = None,
    plot: Annotated[
        Path | None, written_at_end("Draw the return errors before and after: .png, .svg or .pdf.")
    ] = None,
    method: Annotated[
        MethodChoice, typer.Option(help="Method whose result --out, --plot and --profile take.")
    ] = "exact",
    check: Annotated[
        bool, typer.Option("--check", help="Check my numbers: print every step, formula by formula.")
    ] = False,
    tape: Annotated[
        tuple[float, float] | None,
        typer.Option(help="A straight: MEASURED CALCULATED [m]; their ratio is E_s."),
    ] = None,
    previous: Annotated[
        Path | None,
        typer.Option(
            exists=True, help="vehicle.toml before the first pass: print the factors of all passes together."
        ),
    ] = None,
    bumps: Annotated[
        list[Path] | None,
        typer.Option(help="Recording of squares with bumps: the extended UMBmark.", exists=True),
    ] = None,
    profile: Profile = None,
    export_as: Annotated[
        ExportFormat | None,
        typer.Option("--export", help="Print the result in this format, and nothing else."),
    ] = None,
    wheel_width: Annotated[
        float | None, typer.Option(help="Width of a wheel [m], which a VDA 5050 factsheet states.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Use a result that the checks refuse.")] = False,
) -> None:
    """Begin with this: calibrate wheelbase and wheel diameters from squares (UMBmark)."""
    from omnimate.calib.scale import scale_from_tape
    from omnimate.cli.umbmark.calibration import (
        calibrated_trucks,
        calibrated_vehicle,
        export,
        load_cases,
        print_advice,
        result_of,
    )
    from omnimate.cli.umbmark.report import METHOD_WORDS, draw, extended, report, show_worksheet

    if plot is not None:
        from omnimate.figures.files import check_format

        check_format(plot)
    cases, robot = load_cases(sources, truck, side, vehicle_of(vehicle))
    for case in cases if check else ():
        show_worksheet(case)
    e_s = 1.0 if tape is None else scale_from_tape([tape[0]], [tape[1]]).e_s
    results = [result_of(case, method, e_s) for case in cases]
    calibrated = calibrated_vehicle(results, robot) if out_file is not None else None
    if export_as is not None:
        text = export(export_as, results, robot, wheel_width)
        print_advice(results, force=force)
        out.print(text, end="")
    else:
        report(results, e_s, vehicle_of(previous))
        for folder in bumps or ():
            extended(cases, folder, side)
        print_advice(results, force=force)
    if plot is not None:
        draw(results, plot)
    if calibrated is not None:
        write_vehicle(calibrated, out_file, f"calibrated ({METHOD_WORDS[method]})")
    if profile is not None:
        write_profile(profile, calibrated_trucks(results))
