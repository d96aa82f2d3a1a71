"""`python -m studies reproduce`: the three papers' numbers, recomputed."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from omnimate.cli.console import out, progress_bar, report_problem

if TYPE_CHECKING:
    from collections.abc import Sequence

    from studies.papers.rows import Row

_WIDTH, _WHAT = 118, 42
_INDENT = " " * 17


def reproduce(
    quick: Annotated[bool, typer.Option("--quick", help="A small portion, in less than a minute.")] = False,
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Folder for the papers' figures, drawn from simulation.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that compute at once.")] = 2,
) -> None:
    """Recompute the numbers of the three papers: printed, ours, verdict."""
    from studies.papers.figures import draw_all
    from studies.papers.rows import LEGEND
    from studies.papers.table import run, stages, under_way

    plan = stages(quick=quick)
    total = len(plan) + (figures is not None)
    rows: dict[str, tuple[Row, ...]] = {}
    written: list[Path] = []
    with progress_bar(", ".join(under_way(plan, [], jobs))) as report:
        report(0, total)
        for name, computed in run(plan, jobs):
            rows[name] = computed
            report(len(rows), total, ", ".join(under_way(plan, [*rows], jobs)) or "drawing")
        for path in draw_all(figures) if figures is not None else ():
            written.append(path)
            report(len(rows), total, f"drawing {path.name}")
    for name, _ in plan:
        _show(name, rows[name])
    out.print(f"\n{fill(LEGEND, _WIDTH)}", soft_wrap=True)
    for path in written:
        out.print(f"wrote {path}", soft_wrap=True)


def _show(name: str, rows: Sequence[Row]) -> None:
    """Print a stage's rows, and below them why a row is as it is."""
    head = _line("place", name, "printed", "ours", "5-95 %", "verdict")
    out.print(Text(f"\n{head}", style="bold"), soft_wrap=True)
    for row in rows:
        first, *rest = wrap(row.what, _WHAT)
        place = f"{row.paper} {row.place}"
        out.print(_line(place, first, row.printed, row.ours, row.scatter, row.verdict), soft_wrap=True)
        for more in rest:
            out.print(_line("", more).rstrip(), soft_wrap=True)
        if row.note:
            out.print(
                fill(row.note, _WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT), soft_wrap=True
            )
        if row.verdict == "differs":
            report_problem(f"{row.paper} {row.place}, {row.what}: printed {row.printed}, ours {row.ours}")


def _line(place: str, what: str, *columns: str) -> str:
    """Return a line of the table; its last columns are printed, ours, scatter and verdict."""
    widths = (12, 24, 13, 11)
    cells = "".join(f"{cell:<{width}}" for cell, width in zip(columns, widths, strict=False))
    return f"{place:<17}{what:<{_WHAT}} {cells}".rstrip()
