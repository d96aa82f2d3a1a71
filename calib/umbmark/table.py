"""Tape-measured return errors from a CSV table.

Its header states the units; each line is one run. The heading may be left out:

    direction,x_mm,y_mm,theta_deg
    cw,-152,-148,-1.9
    ccw,305,-298,2.7

x points forward at the start, y to the left; each value is absolute minus calculated, U (3.1). Lengths in
`_mm`, `_cm` or `_m`, headings in `_deg` or `_rad`. Empty lines and lines that begin with # are skipped.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.calib.errors import ReturnTableError
from omnimate.calib.umbmark.return_errors import MAX_RETURN_SIDES, ReturnErrors, check_directions

_UNITS = {
    "x": {"mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "y": {"mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "theta": {"deg": math.pi / 180.0, "rad": 1.0},
}
_EXAMPLE = "direction,x_mm,y_mm,theta_deg"


@dataclass(frozen=True, slots=True)
class _Column:
    name: str  # as in the header
    quantity: str  # direction, x, y or theta
    scale: float  # to SI units


def read_table(path: Path | str, side: float) -> ReturnErrors:
    """Return the return errors of a CSV table for a square of `side` [m].

    Raises:
        ReturnTableError: The table cannot be read; the error names line and column.
        DirectionError: A direction is missing, or cw and ccw are swapped.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ReturnTableError(path, 1, None, f"cannot be read: {error}") from error
    rows = [
        (number, [cell.strip() for cell in next(csv.reader([line]))])
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise ReturnTableError(path, 1, None, f"empty; expected a header such as {_EXAMPLE}")
    columns = _header(path, *rows[0])
    runs: dict[str, list[list[float]]] = {"cw": [], "ccw": []}
    for line, cells in rows[1:]:
        direction, values = _run(path, line, cells, columns, side)
        runs[direction].append(values)
    clusters = {name: np.array(lines, np.float64).reshape(-1, 3) for name, lines in runs.items()}
    errors = ReturnErrors(clusters["cw"], clusters["ccw"], side, str(path))
    check_directions(errors)
    return errors


def _header(path: Path, line: int, cells: list[str]) -> list[_Column]:
    columns = []
    for number, name in enumerate(cells, start=1):
        quantity, _, unit = name.partition("_")
        if name == "direction":
            columns.append(_Column(name, name, 1.0))
        elif unit in _UNITS.get(quantity, {}):
            columns.append(_Column(name, quantity, _UNITS[quantity][unit]))
        else:
            expected = "direction, x_mm, y_mm, theta_deg (or x_cm, x_m, theta_rad and so on)"
            raise ReturnTableError(path, line, number, f"column {name!r} is unknown; expected {expected}")
    quantities = [column.quantity for column in columns]
    for quantity in ("direction", "x", "y"):
        if quantity not in quantities:
            raise ReturnTableError(path, line, None, f"no column {quantity}; expected {_EXAMPLE}")
    for quantity in set(quantities):
        if quantities.count(quantity) > 1:
            raise ReturnTableError(path, line, None, f"column {quantity} stands twice; expected {_EXAMPLE}")
    return columns


def _run(
    path: Path, line: int, cells: list[str], columns: list[_Column], side: float
) -> tuple[str, list[float]]:
    """Return the direction and the return error (x, y, theta) [m, m, rad] of one line."""
    if len(cells) != len(columns):
        raise ReturnTableError(
            path, line, None, f"{len(cells)} values; expected {len(columns)} as in the header"
        )
    direction = ""
    error = {"x": math.nan, "y": math.nan, "theta": math.nan}
    for number, (cell, column) in enumerate(zip(cells, columns, strict=True), start=1):
        if column.quantity != "direction":
            error[column.quantity] = _value(path, line, number, cell, column, side)
        elif cell.lower() in {"cw", "ccw"}:
            direction = cell.lower()
        else:
            raise ReturnTableError(path, line, number, f"direction {cell!r}; expected cw or ccw")
    return direction, [error["x"], error["y"], error["theta"]]


def _value(path: Path, line: int, number: int, cell: str, column: _Column, side: float) -> float:
    if column.quantity == "theta" and not cell:
        return math.nan
    try:
        value = float(cell) * column.scale
    except ValueError:
        raise ReturnTableError(path, line, number, f"{column.name} {cell!r}; expected a number") from None
    limit, words = (
        (math.pi, "half a turn")
        if column.quantity == "theta"
        else (MAX_RETURN_SIDES * side, "the whole way around the square")
    )
    if not abs(value) < limit:
        raise ReturnTableError(
            path,
            line,
            number,
            f"{column.name} {cell} is no return error; expected less than {words}; check the unit",
        )
    return value
