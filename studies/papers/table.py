"""All rows in their order, stage by stage, so that progress can be shown."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from studies.papers.lap_table import omnimate_laps
from studies.papers.linkage_numbers import linkage_numbers
from studies.papers.protocols import rectangular_path, straight_line
from studies.papers.square_numbers import square_numbers
from studies.papers.squares import TABLE_I, statistics, table_i

if TYPE_CHECKING:
    from collections.abc import Callable

    from studies.papers.rows import Row

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
