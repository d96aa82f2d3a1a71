"""The table of rooms, from the code itself: it stands where a page has the line `[[rooms]]`."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[2]
PLACE = "[[rooms]]"
IMPORTED = re.compile(r"^\s*from omnimate\.(\w+)", re.MULTILINE)


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the table into the page that asks for it."""
    return markdown.replace(PLACE, "".join(_table())) if PLACE in markdown else markdown


def _table() -> Iterator[str]:
    yield "| room | what it holds | imports |\n| --- | --- | --- |\n"
    rooms = [path.parent for path in ROOT.glob("*/__init__.py")]
    for room in sorted(rooms, key=lambda room: len(imported_rooms(room))):
        yield f"| `{room.name}/` | {_about(room)} | {', '.join(sorted(imported_rooms(room)))} |\n"
        for folder in sorted(path.parent for path in room.glob("*/__init__.py")):
            yield f"| `{room.name}/{folder.name}/` | {_about(folder)} | |\n"


def _about(folder: Path) -> str:
    """Return the first paragraph of a package's docstring."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or ""
    return " ".join(text.split("\n\n")[0].split())


def imported_rooms(room: Path) -> set[str]:
    """Return the other rooms whose modules a room's files import."""
    named = {name for path in room.rglob("*.py") for name in IMPORTED.findall(path.read_text())}
    return {name for name in named if (ROOT / name / "__init__.py").exists()} - {room.name}
