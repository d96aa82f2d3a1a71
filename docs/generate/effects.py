"""The tables of effects and of the variables of laws, where a page has `[[effects]]` or `[[variables]]`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from omnimate.effects import EFFECTS
from omnimate.effects.variables import VARIABLES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.effects.effect import Effect, Parameter


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables into the page that asks for them."""
    for place, table in (("[[effects]]", _effects), ("[[variables]]", _variables)):
        if place in markdown:
            markdown = markdown.replace(place, "".join(table()))
    return markdown


def _variables() -> Iterator[str]:
    yield "| variable | unit | what it is |\n| --- | --- | --- |\n"
    yield from (
        f"| `{name}` | {variable.unit} | {variable.about} |\n" for name, variable in VARIABLES.items()
    )


def _effects() -> Iterator[str]:
    for kind in EFFECTS:
        yield f"### `{kind.name}`\n\n{_doc(kind)}\n\n"
        stages = dict.fromkeys(kind(component).acts_at() for component in kind.components)
        components = ", ".join(f"`{name}`" for name in kind.components)
        yield f"Stage: {', '.join(stages)}. Components: {components}.\n\n"
        yield "| parameter | unit | no effect | from | to |\n| --- | --- | --- | --- | --- |\n"
        yield from (_row(parameter) for parameter in kind.parameters)
        yield "".join(f"\n`{text.name}`: {text.about}.\n" for text in kind.texts)
        yield "\n"


def _doc(kind: type[Effect]) -> str:
    """Return what the module of an effect says."""
    return (sys.modules[kind.__module__].__doc__ or "").strip()


def _row(parameter: Parameter) -> str:
    numbers = (parameter.null, parameter.low, parameter.high)
    shown = ("" if value is None else f"{value:g}" for value in numbers)
    return f"| `{parameter.name}` | {parameter.unit} | {' | '.join(shown)} |\n"
