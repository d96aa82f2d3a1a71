"""The table of faults, from the faults themselves: it stands where a page has the line `[[faults]]`."""

from __future__ import annotations

from dataclasses import fields

from omnimate.vcan_sim.faults import FAULTS

PLACE = "[[faults]]"


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the table into the page that asks for it."""
    rows = ["| fault | what happens | options |", "| --- | --- | --- |"]
    for kind in FAULTS:
        text = " ".join((kind.__doc__ or "").split("\n\n")[0].split())
        options = ", ".join(f"`{field.name}`" for field in fields(kind))
        rows.append(f"| `{kind.name}` | {text} | {options} |")
    return markdown.replace(PLACE, "\n".join(rows))
