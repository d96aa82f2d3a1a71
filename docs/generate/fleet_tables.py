"""The tables of a fleet's results, where a page has the line `[[fleet tables]]`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.fleet.batch.tables import TABLES

if TYPE_CHECKING:
    from collections.abc import Iterator

PLACE = "[[fleet tables]]"


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables into the page that asks for them."""
    return markdown.replace(PLACE, "\n".join(_tables())) if PLACE in markdown else markdown


def _tables() -> Iterator[str]:
    for name, columns in TABLES.items():
        yield f"## {name}\n\n| column | type | unit or meaning |\n| --- | --- | --- |"
        yield from (f"| `{column}` | `{kind}` | {meaning} |" for column, (kind, meaning) in columns.items())
        yield ""
