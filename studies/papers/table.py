"""All rows in their order, stage by stage, computed in this process or in several at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context

from studies.papers.linkage_numbers import linkage_numbers
from studies.papers.protocols import omnimate_laps, rectangular_path, straight_line
from studies.papers.rows import Row
from studies.papers.squares import TABLE_I, square_numbers, statistics, table_i

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
