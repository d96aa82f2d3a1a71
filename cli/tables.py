"""Tables in the style of all verbs, printed at their natural width also into a pipe."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from omnimate.cli.console import out

_WIDEST = 400  # characters: any table of ours fits


def new_table(title: str, left: Sequence[str] = (), right: Sequence[str] = ()) -> Table:
    """Return an empty table with columns of words, then columns of numbers."""
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, collapse_padding=True, pad_edge=False)
    for head in left:
        table.add_column(Text(head))
    for head in right:
        table.add_column(Text(head), justify="right")
    return table


def show(table: Table, widest: int = _WIDEST) -> None:
    """Print a table at its natural width of at most so many characters, also into a pipe."""
    options = out.options.update(max_width=widest)
    table.width = Measurement.get(out, options, table).maximum
    out.print(table, soft_wrap=True)
