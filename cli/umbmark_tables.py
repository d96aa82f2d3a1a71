"""The tables and sentences that `omnimate umbmark` prints: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from cli.console import out

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.experiment import Calibration
    from calib.umbmark import Method
    from calib.uncertainty import Interval
    from cli.umbmark_sources import Case

METHOD_WORDS: dict[Method, str] = {
    "printed-x": "printed, x",
    "printed-y": "printed, y",
    "printed": "printed, x and y",
    "printed-true-b": "printed, true b",
    "heading": "headings alone",
    "exact": "exact chain",
    "weighted": "exact, weighted",
}
_WIDEST = 400  # characters: any table of ours fits


def errors_table(cases: Sequence[Case]) -> Table:
    """Return the table of what was measured: U (3.2)-(3.4) and the angles of (4.20) and (4.24)."""
    from calib.umbmark import angles_from_x, angles_from_y

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


def new_table(title: str) -> Table:
    """Return an empty table in the style of all."""
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)


def _row(result: Calibration) -> tuple[str, ...]:
    from calib.uncertainty import uncertainty_of

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


def show(table: Table) -> None:
    """Print a table at its natural width, also into a pipe."""
    options = out.options.update(max_width=_WIDEST)
    table.width = Measurement.get(out, options, table).maximum
    out.print(table, soft_wrap=True)


def millimetres(metres: float) -> str:
    """Return a length in millimetres, or a dash where it is unknown."""
    return "-" if math.isnan(metres) else f"{1e3 * metres:.1f}"
