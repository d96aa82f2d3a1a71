"""Tables that come from the code itself: each stands where a page has a line such as `[[faults]]`."""

from __future__ import annotations

import ast
import re
import sys
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from omnimate.cli.config_file import options_by_key
from omnimate.cli.verbs import load_verb
from omnimate.effects import EFFECTS
from omnimate.effects.variables import VARIABLES
from omnimate.fleet.batch.tables import TABLES
from omnimate.vcan_sim.faults import FAULTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from omnimate.effects.effect import Parameter

ROOT = Path(__file__).parents[2]
IMPORTED = re.compile(r"^\s*from omnimate\.(\w+)", re.MULTILINE)


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables into the page that asks for them."""
    for place, table in PLACES.items():
        if place in markdown:
            markdown = markdown.replace(place, "\n".join(table()))
    return markdown


def _variables() -> Iterator[str]:
    yield "| variable | unit | what it is |\n| --- | --- | --- |"
    yield from (f"| `{name}` | {variable.unit} | {variable.about} |" for name, variable in VARIABLES.items())
    yield ""


def _effects() -> Iterator[str]:
    for kind in EFFECTS:
        yield f"### `{kind.name}`\n\n{(sys.modules[kind.__module__].__doc__ or '').strip()}\n"
        stages = dict.fromkeys(kind(component).acts_at() for component in kind.components)
        components = ", ".join(f"`{name}`" for name in kind.components)
        yield f"Stage: {', '.join(stages)}. Components: {components}.\n"
        yield "| parameter | unit | no effect | from | to |\n| --- | --- | --- | --- | --- |"
        yield from (_parameter(parameter) for parameter in kind.parameters)
        yield from (f"\n`{text.name}`: {text.about}." for text in kind.texts)
        yield ""
    yield ""


def _parameter(parameter: Parameter) -> str:
    numbers = (parameter.null, parameter.low, parameter.high)
    shown = ("" if value is None else f"{value:g}" for value in numbers)
    return f"| `{parameter.name}` | {parameter.unit} | {' | '.join(shown)} |"


def _faults() -> Iterator[str]:
    yield "| fault | what happens | options |\n| --- | --- | --- |"
    for kind in FAULTS:
        text = " ".join((kind.__doc__ or "").split("\n\n")[0].split())
        options = ", ".join(f"`{field.name}`" for field in fields(kind))
        yield f"| `{kind.name}` | {text} | {options} |"


def _fleet_tables() -> Iterator[str]:
    for name, columns in TABLES.items():
        yield f"## {name}\n\n| column | type | unit or meaning |\n| --- | --- | --- |"
        yield from (f"| `{column}` | `{kind}` | {meaning} |" for column, (kind, meaning) in columns.items())
        yield ""


def _serve_options() -> Iterator[str]:
    command = load_verb("serve")
    keys = options_by_key(command)
    yield "| option | environment | key of the file | default | what it is |\n| --- | --- | --- | --- | --- |"
    for option in command.params:
        if option.name == "help":
            continue
        key = option.opts[0].removeprefix("--")
        in_file = f"`{key}`" if key in keys else ""
        default = "" if option.default is None else f"`{option.default}`"
        yield f"| `--{key}` | `{option.envvar}` | {in_file} | {default} | {option.help} |"


def _rooms() -> Iterator[str]:
    yield "| room | what it holds | imports |\n| --- | --- | --- |"
    rooms = [path.parent for path in ROOT.glob("*/__init__.py")]
    for room in sorted(rooms, key=lambda room: len(imported_rooms(room))):
        yield f"| `{room.name}/` | {_about(room)} | {', '.join(sorted(imported_rooms(room)))} |"
        for folder in sorted(path.parent for path in room.glob("*/__init__.py")):
            yield f"| `{room.name}/{folder.name}/` | {_about(folder)} | |"
    yield ""


def _about(folder: Path) -> str:
    """Return the first paragraph of a package's docstring."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text())) or ""
    return " ".join(text.split("\n\n")[0].split())


def imported_rooms(room: Path) -> set[str]:
    """Return the other rooms whose modules a room's files import."""
    named = {name for path in room.rglob("*.py") for name in IMPORTED.findall(path.read_text())}
    return {name for name in named if (ROOT / name / "__init__.py").exists()} - {room.name}


PLACES: dict[str, Callable[[], Iterator[str]]] = {
    "[[effects]]": _effects,
    "[[variables]]": _variables,
    "[[faults]]": _faults,
    "[[fleet tables]]": _fleet_tables,
    "[[serve options]]": _serve_options,
    "[[rooms]]": _rooms,
}
