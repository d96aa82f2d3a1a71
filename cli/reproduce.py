"""`omnimate reproduce`: the three papers' numbers, recomputed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.progress import track
from rich.table import Table

from cli.console import err, flaw
from cli.umbmark_tables import show

if TYPE_CHECKING:
    from reproduction.rows import Row


def reproduce(
    quick: Annotated[bool, typer.Option("--quick", help="A small portion, in less than a minute.")] = False,
) -> None:
    """Recompute the numbers of the three papers: printed, ours, verdict."""
    from reproduction.table import stages

    rows: list[Row] = []
    for _name, stage in track(stages(quick=quick), "reproducing", console=err, transient=True):
        rows += stage()
    table = Table("", "place", "what", "printed", "ours", "verdict", box=SIMPLE_HEAD)
    for row in rows:
        table.add_row(row.paper, row.place, row.what, row.printed, row.ours, row.verdict)
    show(table)
    for row in rows:
        if row.verdict == "differs":
            flaw(f"{row.paper} {row.place}, {row.what}: printed {row.printed}, ours {row.ours}")
