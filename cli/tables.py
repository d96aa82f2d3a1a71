"""Tables in the style of all verbs, printed at their natural width also into a pipe."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.measure import Measurement
from rich.table import Table

from omnimate.cli.console import out

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

_MAX_WIDTH = 10_000  # characters: any table of ours fits
_SCREEN_WIDTH = 80  # characters of a screen on which a table with folded cells is readable


def new_table(
    title: str, left: Sequence[str] = (), right: Sequence[str] = (), rows: Iterable[Sequence[str]] = ()
) -> Table:
    """Return a table with columns of words, then columns of numbers; cells are plain text, without markup."""
    table = Table(
        title=title or None, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False
    )
    for head in left:
        table.add_column(head)
    for head in right:
        table.add_column(head, justify="right")
    for row in rows:
        table.add_row(*row)
    return table


def pose_cells(pose: Array) -> tuple[str, str, str]:
    """Return x, y [m] and heading [degrees] of a pose `(3,)` as cells."""
    x, y, theta = pose.tolist()
    return f"{x:.4f}", f"{y:.4f}", f"{math.degrees(theta):.3f}"


def show(table: Table, *, folds: bool = False) -> None:
    """Print a table at its natural width, also into a pipe; `folds` folds long cells on a screen."""
    max_width = max(_SCREEN_WIDTH, out.width) if folds and out.is_terminal else _MAX_WIDTH
    options = out.options.update(max_width=max_width)
    table.width = Measurement.get(out, options, table).maximum
    out.print(table)
