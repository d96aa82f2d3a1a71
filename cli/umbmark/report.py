"""Tables, sentences and figures of `omnimate umbmark`: confidence intervals, whether to go on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.text import Text

from omnimate.calib.apply import factors_between
from omnimate.calib.umbmark.bootstrap import RESAMPLES, bootstrap, can_bootstrap
from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.calib.umbmark.extended import extended_umbmark
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.printed import printed_angles
from omnimate.calib.umbmark.return_errors import stop_rule
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.calib.umbmark.worksheet import worksheet
from omnimate.cli.console import say
from omnimate.cli.loading import load
from omnimate.cli.tables import new_table, show

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rich.table import Table

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.extended import ExtendedResult
    from omnimate.calib.umbmark.printed import Method
    from omnimate.calib.umbmark.uncertainty import Interval
    from omnimate.cli.umbmark.calibration import Case, Result
    from omnimate.vehicle.parameters import Truck, VehicleParameters

METHOD_WORDS: dict[Method, str] = {
    "printed-x": "printed, x",
    "printed-y": "printed, y",
    "printed": "printed, x and y",
    "printed-true-b": "printed, true b",
    "heading": "headings alone",
    "exact": "exact chain",
    "weighted": "exact, weighted",
}


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
    """Return one method's estimates of a truck, with 95 % confidence."""
    bounds, errors = uncertainty_of(calibration), calibration.experiment.errors
    factors = calibration.factors
    lines = [
        f"{case.label}: {METHOD_WORDS[calibration.correction.method]}, 95 % confidence:",
        f"  wheelbase {within(bounds.wheelbase, 1e3, 2)} mm",
        f"  left wheel {within(bounds.diameter_left, 1e3, 3)} mm, c_L {factors.c_left:.5f}",
        f"  right wheel {within(bounds.diameter_right, 1e3, 3)} mm, c_R {factors.c_right:.5f}",
    ]
    if can_bootstrap(errors):
        drawn = bootstrap(calibration).uncertainty
        lines.append(
            f"  {RESAMPLES} resamples: E_b {drawn.e_b.low:.5f} to {drawn.e_b.high:.5f}, "
            f"E_d {drawn.e_d.low:.5f} to {drawn.e_d.high:.5f}"
        )
    if bounds.freedom:
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
    table = new_table(f"{case.label}: U (3.2) to (4.33), step by step", ("U", "", "="), ("",))
    for step in worksheet(case.experiment.errors, case.experiment.truck):
        digits = {"mm": 2, "deg": 4}.get(step.unit, 6)
        table.add_row(
            f"({step.number})", step.symbol, step.how, f"{step.value:.{digits}f} {step.unit}".rstrip()
        )
    show(table)


def errors_table(cases: Sequence[Case]) -> Table:
    """Return the table of what was measured: U (3.2)-(3.4) and the angles of (4.20) and (4.24)."""
    heads = (
        "runs\ncw + ccw",
        "centre cw\nx, y",
        "centre ccw\nx, y",
        "alpha from\nx, y",
        "beta from\nx, y",
        "SEM",
        "worst\nrun",
        "E_max,syst",
    )
    table = new_table(
        "Return errors: absolute minus calculated, millimetres and degrees", ("experiment",), heads
    )
    for case in cases:
        errors = case.experiment.errors
        cw, ccw = errors.centres
        (alpha_x, beta_x), (alpha_y, beta_y) = printed_angles(errors.centres, errors.side).tolist()
        table.add_row(
            case.label,
            f"{len(errors.cw)} + {len(errors.ccw)}",
            f"{1e3 * cw[0]:.1f}, {1e3 * cw[1]:.1f}",
            f"{1e3 * ccw[0]:.1f}, {1e3 * ccw[1]:.1f}",
            f"{math.degrees(alpha_x):+.3f}, {math.degrees(alpha_y):+.3f}",
            f"{math.degrees(beta_x):+.3f}, {math.degrees(beta_y):+.3f}",
            millimetres(errors.sem),
            millimetres(errors.worst),
            millimetres(errors.e_max_syst),
        )
    return table


def calibration_table(cases: Sequence[Case], calibrations: Sequence[Sequence[Calibration]]) -> Table:
    """Return the table of what each method makes of it, with the errors of the same runs before and after."""
    heads = (
        "E_b",
        "E_d",
        "wheelbase\n[mm]",
        "left\n[mm]",
        "right\n[mm]",
        "worst run\n[mm]",
        "E_max,syst\n[mm]",
    )
    table = new_table(
        "Calibration with 95 % confidence, and the same runs evaluated with it", ("method",), heads
    )
    for case, results in zip(cases, calibrations, strict=True):
        table.add_row(Text(case.label, overflow="fold"))
        for result in results:
            table.add_row(*_row(result))
        table.add_section()
    return table


def _row(result: Calibration) -> tuple[str, ...]:
    before, after, truck = result.experiment.errors, result.errors, result.truck
    bounds = uncertainty_of(result)
    return (
        f"  {METHOD_WORDS[result.correction.method]}",
        within(bounds.e_b),
        within(bounds.e_d),
        f"{1e3 * truck.wheelbase:.2f}",
        f"{1e3 * truck.wheel_diameter_left:.3f}",
        f"{1e3 * truck.wheel_diameter_right:.3f}",
        f"{millimetres(before.worst)} -> {millimetres(after.worst)}",
        f"{millimetres(before.e_max_syst)} -> {millimetres(after.e_max_syst)}",
    )


def within(interval: Interval, factor: float = 1.0, digits: int = 5) -> str:
    """Return a value with half the width of its interval, times a factor; without it where it is unknown."""
    value = f"{factor * interval.value:.{digits}f}"
    return value if math.isnan(interval.half) else f"{value} ± {factor * interval.half:.{digits}f}"


def millimetres(metres: float) -> str:
    """Return a length in millimetres, or a dash where it is unknown."""
    return "-" if math.isnan(metres) else f"{1e3 * metres:.1f}"
