"""What `omnimate umbmark` prints and draws: tables, confidence intervals, whether to go on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.text import Text

from omnimate.calib.apply import factors_between
from omnimate.calib.umbmark.bootstrap import RESAMPLES, bootstrap, can_bootstrap
from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.calib.umbmark.extended import extended_umbmark
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.return_errors import stop_rule
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.calib.umbmark.worksheet import worksheet
from omnimate.cli.console import say
from omnimate.cli.loading import load
from omnimate.cli.tables import new_table, show
from omnimate.cli.umbmark.tables import METHOD_WORDS, calibration_table, errors_table, within

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.extended import ExtendedResult
    from omnimate.cli.umbmark.results import Result
    from omnimate.cli.umbmark.sources import Case
    from omnimate.vehicle.parameters import Truck, VehicleParameters


def report(results: Sequence[Result], e_s: float, before: VehicleParameters | None) -> None:
    """Print the tables and the sentences; `before` is the robot before its first pass."""
    cases = [result.case for result in results]
    show(errors_table(cases))
    show(calibration_table(cases, [result.assessment.calibrations for result in results]))
    for result in results:
        for line in summary(result.case, result.chosen):
            say(line)
        say(f"  {stop_rule(result.case.experiment.errors)}")
        if before is not None and result.case.truck in before.trucks:
            say(f"  {all_passes(before.trucks[result.case.truck], result.truck)}")
    if e_s != 1.0:
        say(f"E_s {e_s:.5f} by tape: wheels and wheelbase are written {e_s:.5f} times as large")


def extended(cases: Sequence[Case], folder: Path, side: float | None) -> None:
    """Print the extended UMBmark: the squares of each truck against those of a recording with bumps."""
    for case in cases:
        smooth = case.experiment.errors
        bumpy = experiment_of_recordings([load(folder)], case.truck, side).errors
        result = extended_umbmark(smooth.cw[:, 2], smooth.ccw[:, 2], bumpy.cw[:, 2], bumpy.ccw[:, 2])
        say(f"{case.label}: {extended_words(result)}")


def draw(results: Sequence[Result], path: Path) -> None:
    """Draw the return errors of each truck before and after its calibration, as U Fig. 11.

    Raises:
        PlotError: The file cannot be written.
    """
    from omnimate.figures.clusters import Clusters, plot_clusters

    panels = [
        Clusters(result.case.label, result.case.experiment.errors, result.chosen.errors) for result in results
    ]
    plot_clusters(panels, path)
    say(f"figure: {path}")


def summary(case: Case, calibration: Calibration) -> list[str]:
    """Return what one method knows about a truck, with 95 % confidence."""
    known, errors = uncertainty_of(calibration), calibration.experiment.errors
    lines = [
        f"{case.label}: {METHOD_WORDS[calibration.correction.method]}, 95 % confidence:",
        f"  wheelbase {within(known.wheelbase, 1e3, 2)} mm",
        f"  left wheel {within(known.diameter_left, 1e3, 3)} mm, c_L {calibration.c_left:.5f}",
        f"  right wheel {within(known.diameter_right, 1e3, 3)} mm, c_R {calibration.c_right:.5f}",
    ]
    if can_bootstrap(errors):
        drawn = bootstrap(calibration).uncertainty
        lines.append(
            f"  {RESAMPLES} resamples: E_b {drawn.e_b.low:.5f} to {drawn.e_b.high:.5f}, "
            f"E_d {drawn.e_d.low:.5f} to {drawn.e_d.high:.5f}"
        )
    if known.freedom:
        rough = floor_roughness(errors, calibration.truck.wheelbase)
        lines.append(
            f"  the floor scatters each wheel by {1e3 * rough.value:.2f} mm/sqrt(m) "
            f"({1e3 * rough.low:.2f} to {1e3 * rough.high:.2f})"
        )
    return lines


def all_passes(first: Truck, last: Truck) -> str:
    """Return the factors of all passes together, from the parameters before the first."""
    factors = factors_between(first, last)
    return (
        f"all passes together: E_b {factors.e_b:.5f}, E_d {factors.e_d:.5f}, "
        f"c_L {factors.c_left:.5f}, c_R {factors.c_right:.5f}"
    )


def extended_words(result: ExtendedResult) -> str:
    """Return the extended UMBmark's results [degrees]."""
    cw, ccw = (math.degrees(angle) for angle in result.systematic)
    return (
        f"extended UMBmark: mean return heading without bumps {cw:+.2f} (cw) and {ccw:+.2f} (ccw) degrees; "
        f"with bumps it differs by {math.degrees(result.worst):.2f} degrees at worst (O 3), "
        f"by {math.degrees(result.average):.2f} as the sum of both averages"
    )


def show_worksheet(case: Case) -> None:
    """Print every step of the calculation, formula by formula."""
    table = new_table(f"{case.label}: U (3.2) to (4.33), step by step")
    table.add_column("U")
    table.add_column("")
    table.add_column("=")
    table.add_column("", justify="right")
    for step in worksheet(case.experiment.errors, case.experiment.truck):
        digits = {"mm": 2, "deg": 4}.get(step.unit, 6)
        table.add_row(
            f"({step.number})", step.symbol, Text(step.how), f"{step.value:.{digits}f} {step.unit}".rstrip()
        )
    show(table)
