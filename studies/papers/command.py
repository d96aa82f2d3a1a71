"""`python -m studies reproduce`: the three papers' numbers, recomputed stage by stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from textwrap import fill, wrap
from typing import Annotated

import typer
from rich.text import Text

from omnimate.cli.console import out, progress_bar, report_problem
from studies.papers.figures import draw_all
from studies.papers.linkage_numbers import linkage_numbers
from studies.papers.protocols import omnimate_laps, rectangular_path, straight_line
from studies.papers.rows import LEGEND, Row
from studies.papers.squares import TABLE_I, square_numbers, statistics, table_i

_WIDTH, _WHAT = 118, 42
_INDENT = " " * 17
Stage = tuple[str, Callable[[], tuple[Row, ...]]]

FULL, QUICK = (2000, 30, 30), (200, 4, 2)  # trials of the method, drives of Table I, robots of a protocol


def stages(*, quick: bool) -> list[Stage]:
    """Return the stages by name; each gives its rows when it is called, and can be sent to a process."""
    trials, drives, robots = QUICK if quick else FULL
    experiments = range(1) if quick else range(len(TABLE_I))
    return [
        ("U: equations", square_numbers),
        ("C and O: equations", linkage_numbers),
        ("U: the method's statistics", partial(statistics, trials)),
        *((f"U: Table I, #{row + 1}", partial(table_i, row, drives)) for row in experiments),
        ("C 6.1: straight line", partial(straight_line, robots)),
        ("C 6.2: rectangle", partial(rectangular_path, robots)),
        ("O 3: laps", partial(omnimate_laps, robots)),
    ]


def run(plan: Sequence[Stage], jobs: int) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Yield name and rows of each stage once it is computed; one job computes in this process, in order."""
    if jobs == 1:
        for name, stage in plan:
            yield name, stage()
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        names = {pool.submit(stage): name for name, stage in plan}
        for done in as_completed(names):
            yield names[done], done.result()


def under_way(plan: Sequence[Stage], finished: Sequence[str], jobs: int) -> list[str]:
    """Return the names of the stages that are being computed while those named in `finished` are done."""
    return [name for name, _ in plan if name not in finished][:jobs]


def reproduce(
    quick: Annotated[bool, typer.Option("--quick", help="A small portion, in less than a minute.")] = False,
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Folder for the papers' figures, drawn from simulation.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that compute at once.")] = 2,
) -> None:
    """Recompute the numbers of the three papers: printed, ours, verdict."""
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
