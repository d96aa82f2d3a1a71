"""The tables and sentences that `omnimate umbmark` prints: millimetres and degrees."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from calib.umbmark import angles_from_x, angles_from_y
from cli.console import out

if TYPE_CHECKING:
    from collections.abc import Sequence

    from calib.experiment import Calibration
    from calib.return_errors import ReturnErrors
    from calib.umbmark import Method
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
    table = _table("Return errors: absolute minus calculated, millimetres and degrees")
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
            _millimetres(errors.sem),
            _millimetres(errors.worst),
            _millimetres(errors.e_max_syst),
        )
    return table


def calibration_table(cases: Sequence[Case], calibrations: Sequence[Sequence[Calibration]]) -> Table:
    """Return the table of what each method makes of it, with the errors of the same runs before and after."""
    table = _table("Calibration, and the same runs evaluated with it")
    table.add_column("experiment")
    table.add_column("method")
    for head in (
        "E_b",
        "E_d",
        "c_L",
        "c_R",
        "wheelbase\n[mm]",
        "diameter\nleft [mm]",
        "diameter\nright [mm]",
        "worst run\n[mm]",
        "E_max,syst\n[mm]",
    ):
        table.add_column(Text(head), justify="right")
    for case, results in zip(cases, calibrations, strict=True):
        for number, result in enumerate(results):
            table.add_row(Text(case.label if number == 0 else ""), *_row(result))
        table.add_section()
    return table


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)


def _row(result: Calibration) -> tuple[str, ...]:
    before, after, truck = result.experiment.errors, result.errors, result.truck
    return (
        METHOD_WORDS[result.correction.method],
        f"{result.correction.e_b:.5f}",
        f"{result.correction.e_d:.5f}",
        f"{result.c_left:.5f}",
        f"{result.c_right:.5f}",
        f"{1e3 * truck.wheelbase:.2f}",
        f"{1e3 * truck.wheel_diameter_left:.3f}",
        f"{1e3 * truck.wheel_diameter_right:.3f}",
        f"{_millimetres(before.worst)} -> {_millimetres(after.worst)}",
        f"{_millimetres(before.e_max_syst)} -> {_millimetres(after.e_max_syst)}",
    )


def stop_rule(errors: ReturnErrors) -> str:
    """Return what U section V says about calibrating: E_max,syst against 3 SEM."""
    size = f"E_max,syst {_millimetres(errors.e_max_syst)} mm"
    helps = errors.second_pass_helps
    if helps is None:
        return f"{size}; SEM unknown with one run in each direction: drive five"
    limit = f"3 SEM = {_millimetres(3.0 * errors.sem)} mm"
    if helps:
        return f"{size} > {limit}: the systematic errors stand out, calibrating helps"
    return f"{size} <= {limit}: the runs' scatter explains it, calibrating again is unlikely to help"


def show(table: Table) -> None:
    """Print a table at its natural width, also into a pipe."""
    options = out.options.update(max_width=_WIDEST)
    table.width = Measurement.get(out, options, table).maximum
    out.print(table, soft_wrap=True)


def _millimetres(metres: float) -> str:
    return "-" if math.isnan(metres) else f"{1e3 * metres:.1f}"
