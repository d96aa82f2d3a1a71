"""`omnimate reproduce`: the three papers' numbers, recomputed."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.text import Text

from cli.console import err, flaw, out

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rich.progress import TaskID

    from reproduction.rows import Row
    from reproduction.table import Stage

_WIDTH, _WHAT = 118, 42
_INDENT = " " * 17
_WORDS = (
    "misprint: the print is wrong; missed: a printed bound that ours does not keep, and where the error comes"
    " from; unsure: too few robots to tell; unexplained: the paper's own scatter does not make it; shown: for"
    " comparison; agrees of plain laps: within a factor of two, as the paper tells no wheels' errors."
    " In brackets the 95 % interval of the mean. CLAPPER, OmniMate: the papers' equations; dead"
    " band: CLAPPER as `track` runs it. Everything is simulated."
)


def reproduce(
    quick: Annotated[bool, typer.Option("--quick", help="A small portion, in less than a minute.")] = False,
    figures: Annotated[
        Path | None, typer.Option("--figures", help="Folder for the papers' figures, drawn from simulation.")
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=1, help="Processes that compute at once.")] = 2,
) -> None:
    """Recompute the numbers of the three papers: printed, ours, verdict."""
    from reproduction.table import stages

    plan = stages(quick=quick)
    drawing = 0 if figures is None else 1
    columns = TextColumn("{task.description:<44}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*columns, console=err, transient=True) as progress:
        task = progress.add_task("starting", total=len(plan) + drawing)
        found: dict[str, tuple[Row, ...]] = {}
        progress.update(task, description=_under_way(plan, found, jobs))
        for name, rows in _run(plan, jobs):
            found[name] = rows
            progress.update(task, advance=1, description=_under_way(plan, found, jobs))
        written = _draw(figures, progress, task) if figures is not None else []
    for name, _ in plan:
        _show(name, found[name])
    out.print(f"\n{fill(_WORDS, _WIDTH)}", soft_wrap=True)
    for path in written:
        out.print(f"wrote {path}", soft_wrap=True)


def _run(plan: Sequence[Stage], jobs: int) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Yield the stages' names and rows as they are done."""
    if jobs == 1:
        for name, stage in plan:
            yield name, stage()
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        names = {pool.submit(stage): name for name, stage in plan}
        for done in as_completed(names):
            yield names[done], done.result()


def _under_way(plan: Sequence[Stage], found: dict[str, tuple[Row, ...]], jobs: int) -> str:
    """Return the names of the stages that are being computed."""
    return ", ".join([name for name, _ in plan if name not in found][:jobs]) or "drawing"


def _draw(folder: Path, progress: Progress, task: TaskID) -> list[Path]:
    from cli.reproduce_figures import draw_all

    written = []
    for path in draw_all(folder):
        written.append(path)
        progress.update(task, description=f"drawing {path.name}")
    progress.update(task, advance=1)
    return written


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
            flaw(f"{row.paper} {row.place}, {row.what}: printed {row.printed}, ours {row.ours}")


def _line(place: str, what: str, *columns: str) -> str:
    """Return a line of the table; its last columns are printed, ours, scatter and verdict."""
    widths = (12, 24, 13, 11)
    cells = "".join(f"{cell:<{width}}" for cell, width in zip(columns, widths, strict=False))
    return f"{place:<17}{what:<{_WHAT}} {cells}".rstrip()
