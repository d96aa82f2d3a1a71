"""The table of effects, from the effects themselves: it stands where a page has the line `[[effects]]`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from omnimate.vcan_sim.effects import EFFECTS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.vcan_sim.effects.effect import Effect, Parameter

PLACE = "[[effects]]"


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the table into the page that asks for it."""
    return markdown.replace(PLACE, "".join(_table())) if PLACE in markdown else markdown


def _table() -> Iterator[str]:
    for kind in EFFECTS:
        yield f"### `{kind.name}`\n\n{_doc(kind)}\n\n"
        yield f"Stage: {kind.stage}. Components: {', '.join(f'`{name}`' for name in kind.components)}.\n\n"
        yield "| parameter | unit | no effect | from | to |\n| --- | --- | --- | --- | --- |\n"
        yield from (_row(parameter) for parameter in kind.parameters)
        yield "\n"


def _doc(kind: type[Effect]) -> str:
    """Return what the module of an effect says."""
    return (sys.modules[kind.__module__].__doc__ or "").strip()


def _row(parameter: Parameter) -> str:
    numbers = (parameter.null, parameter.low, parameter.high)
    shown = ("" if value is None else f"{value:g}" for value in numbers)
    return f"| `{parameter.name}` | {parameter.unit} | {' | '.join(shown)} |\n"
