"""The blocks of a documentation page that are run: console sessions, Python programs and the files they need.

A page is Markdown. What is run, in the order of the page, in one folder and one shell:

- a `console` block: each line that begins with `$ ` is a command, the lines below it are the output that it
  must print;
- a `python` block: a whole program; a `text` block directly below it is the output that it must print;
- any block with a `title`: a file of that name.

The comment `<!-- not run: REASON -->` above a block leaves it out; its `omnimate` lines are still parsed.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs"
FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,}) *(?P<language>[\w-]*)(?P<options>[^`]*)$")
NOT_RUN = re.compile(r"^ *<!-- not run: (?P<reason>.+) -->$")
SNIPPET = re.compile(r'^ *--8<-- "(?P<path>[^":]+)"$')
TITLE = re.compile(r'title="([^"]+)"')


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block of a page.

    Attributes:
        page: Path of the page.
        line: Number of the first line inside the fence, counted from 1.
        language: The word behind the fence.
        lines: Content without the fence's indentation, snippets included.
        title: Name of the file that the block shows; empty where it shows none.
        not_run: Why the block is not run; empty where it is.
        after: The language of the block above it, if only empty lines stand between them.
    """

    page: Path
    line: int
    language: str
    lines: tuple[str, ...]
    title: str
    not_run: str
    after: str


def groups() -> dict[str, list[Path]]:
    """Return the pages by the folder in which they run: the tutorial's pages share one."""
    pages = sorted(PAGES.rglob("*.md"))
    tutorial = [page for page in pages if page.parent.name == "tutorial"]
    others = {str(page.relative_to(PAGES)): [page] for page in pages if page not in tutorial}
    return {"tutorial": tutorial, **others}


def blocks(page: Path) -> list[Block]:
    """Return the fenced blocks of a page in their order."""
    lines = page.read_text().splitlines()
    result: list[Block] = []
    number, closed, after, reason = 0, -1, "", ""
    while number < len(lines):
        line = lines[number]
        comment, fence = NOT_RUN.match(line), FENCE.match(line)
        if fence is None:
            if comment is not None:
                reason = comment["reason"]
            elif line.strip():
                after, reason = "", ""
            number += 1
            continue
        closed = _end(lines, number, fence)
        content = [text.removeprefix(fence["indent"]) for text in lines[number + 1 : closed]]
        title = TITLE.search(fence["options"])
        block = Block(
            page,
            number + 2,
            fence["language"],
            tuple(included(content)),
            title[1] if title else "",
            reason,
            after,
        )
        result.append(block)
        after, reason, number = block.language, "", closed + 1
    return result


def _end(lines: list[str], start: int, fence: re.Match[str]) -> int:
    for number in range(start + 1, len(lines)):
        if lines[number].strip() == fence["ticks"]:
            return number
    raise ValueError(f"line {start + 1}: the block is not closed; expected {fence['ticks']}")


def included(lines: list[str]) -> list[str]:
    """Return the lines with each snippet line replaced by the file that it names."""
    result: list[str] = []
    for line in lines:
        snippet = SNIPPET.match(line)
        result += (ROOT / snippet["path"]).read_text().splitlines() if snippet else [line]
    return result
