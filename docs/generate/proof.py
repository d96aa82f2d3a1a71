"""The tables of what was proven, where a page has a line such as `[[proof: engine wide]]`.

The figures stand in `docs/data/proof.json`. `python -m docs.generate.proof FOLDER ...` takes over those that
`python -m studies prove --out FOLDER` has written; worlds that no folder holds stay as they are.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

DATA = Path(__file__).parents[1] / "data" / "proof.json"
PLACE = re.compile(r"^\[\[proof: (?P<worlds>[a-z0-9 ]+)\]\]$", re.MULTILINE)
POOLED = "foreign"  # the score over several worlds, which depends on what was run together


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables into the page that asks for them."""
    return PLACE.sub(lambda place: "\n".join(_table(place["worlds"].split())), markdown)


def _table(worlds: Sequence[str]) -> Iterator[str]:
    known = json.loads(DATA.read_text(encoding="utf-8"))["worlds"]
    scores = [known[world] for world in worlds]
    lines = {line["name"]: line for score in scores for line in score["lines"] if _text(line)}
    yield "| what | wanted | " + " | ".join(f"{score['title']}, {score['cases']}" for score in scores) + " |"
    yield "| --- " * (2 + len(scores)) + "|"
    for name, wanted in lines.items():
        cells = [
            next((_text(line) for line in score["lines"] if line["name"] == name), "") for score in scores
        ]
        yield f"| {name} | {_target(wanted)} | {' | '.join(cells)} |"


def _text(line: Mapping[str, Any]) -> str:
    """Return a figure as a table shows it: bold where its target is missed, empty where nothing gives it."""
    if "hits" in line:
        text = f"{line['hits']} of {line['of']}" if line["of"] else ""
    else:
        text = "" if line["value"] is None else line["note"] or f"{line['value']:.3g}"
    return f"**{text}**" if text and line["missed"] else text


def _target(line: Mapping[str, Any]) -> str:
    return "" if line["target"] is None else f"{'<=' if line['most'] else '>='} {line['target']:.2f}"


def take_over(folders: Sequence[Path]) -> None:
    """Write the figures of some studies into the data of the pages, without what no table shows."""
    worlds = json.loads(DATA.read_text(encoding="utf-8"))["worlds"] if DATA.exists() else {}
    for folder in folders:
        measured = json.loads((folder / "proof.json").read_text(encoding="utf-8"))["worlds"]
        for name in measured.keys() - {POOLED}:
            score = measured[name]
            lines = [line for line in score["lines"] if _text(line)]
            worlds[name] = {"title": score["title"], "cases": score["cases"], "lines": lines}
    DATA.write_text(json.dumps({"worlds": worlds}, indent=1, sort_keys=True) + "\n", encoding="utf-8")


if __name__ == "__main__":
    take_over([Path(name) for name in sys.argv[1:]])
