"""The tables and sentences that `omnimate umbmark` prints: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.text import Text

from omnimate.cli.tables import new_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.calib.umbmark.printed import Method
    from omnimate.calib.umbmark.uncertainty import Interval
    from omnimate.cli.umbmark.sources import Case

METHOD_WORDS: dict[Method, str] = {
    "printed-x": "printed, x",
    "printed-y": "printed, y",
    "printed": "printed, x and y",
    "printed-true-b": "printed, true b",
    "heading": "headings alone",
    "exact": "exact chain",
    "weighted": "exact, weighted",
}


def errors_table(cases: Sequence[Case]) -> Table:
    """Return the table of what was measured: U (3.2)-(3.4) and the angles of (4.20) and (4.24)."""
    from omnimate.calib.umbmark.printed import angles_from_x, angles_from_y

    table = new_table("Return errors: absolute minus calculated, millimetres and degrees")
    table.add_column("experiment")
    for head in (
        "runs\ncw + ccw",
        "centre cw\nx, y",
        "centre ccw\nx, y",
        "alpha from\nx, y",
        "beta from\nx, y",
        "SEM",
        "worst\nrun",
        "E_max,syst",
    ):
        table.add_column(Text(head), justify="right")
    for case in cases:
        errors = case.experiment.errors
        cw, ccw = errors.centres
        (alpha_x, beta_x), (alpha_y, beta_y) = angles_from_x(errors), angles_from_y(errors)
        table.add_row(
            Text(case.label),
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
    table = new_table("Calibration with 95 % confidence, and the same runs evaluated with it")
    table.add_column("method")
    for head in (
        "E_b",
        "E_d",
        "wheelbase\n[mm]",
        "left\n[mm]",
        "right\n[mm]",
        "worst run\n[mm]",
        "E_max,syst\n[mm]",
    ):
        table.add_column(Text(head), justify="right")
    for case, results in zip(cases, calibrations, strict=True):
        table.add_row(Text(case.label, overflow="fold"))
        for result in results:
            table.add_row(*_row(result))
        table.add_section()
    return table


def _row(result: Calibration) -> tuple[str, ...]:
    from omnimate.calib.umbmark.uncertainty import uncertainty_of

    before, after, truck = result.experiment.errors, result.errors, result.truck
    known = uncertainty_of(result)
    return (
        f"  {METHOD_WORDS[result.correction.method]}",
        within(known.e_b),
        within(known.e_d),
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
