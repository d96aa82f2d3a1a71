"""The options of `omnimate serve`, where a page has the line `[[serve options]]`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.cli.config_file import options_by_key
from omnimate.cli.verbs import load_verb

if TYPE_CHECKING:
    from collections.abc import Iterator

PLACE = "[[serve options]]"


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the table into the page that asks for it."""
    return markdown.replace(PLACE, "\n".join(_table())) if PLACE in markdown else markdown


def _table() -> Iterator[str]:
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
