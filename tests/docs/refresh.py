"""Write what the commands print today, and the pictures that they draw, into the pages.

Usage: `python -m tests.docs.refresh [PAGE...]`, in the project's folder. Outputs with `...` in them are left
to the author. A picture is refreshed where the comment `<!-- drawn: FILE -->` stands above its line: FILE is
what the page's commands draw; a page in HTML is photographed with chromium.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.docs.pages import groups
from tests.docs.running import Outcome, run

DRAWN = re.compile(r"^<!-- drawn: (?P<file>\S+) -->\n+!\[[^\]]*\]\((?P<picture>[^)]+)\)", re.MULTILINE)


def main(names: list[str]) -> None:
    """Refresh the pages whose names hold one of some words; all pages where there are none."""
    for group, pages in groups().items():
        if names and not any(name in group for name in names):
            continue
        with tempfile.TemporaryDirectory() as parent:
            folder = Path(parent) / "page"
            folder.mkdir()
            outcomes = run(pages, folder)
            for outcome in reversed(outcomes):
                _write(outcome)
            for page in pages:
                _draw(page, folder)


def _write(outcome: Outcome) -> None:
    """Replace the output that a page shows by the one that was printed."""
    step = outcome.step
    if not outcome.problem:
        return
    if outcome.code or step.shown is None or any("..." in line for line in step.shown):
        print(outcome.problem, file=sys.stderr)
        return
    lines = step.block.page.read_text().split("\n")
    first = step.first - 1
    indent = " " * (len(lines[step.line - 1]) - len(lines[step.line - 1].lstrip()))
    printed = [(indent + line).rstrip() for line in outcome.printed]
    lines[first : first + len(step.shown)] = printed
    step.block.page.write_text("\n".join(lines))


def _draw(page: Path, folder: Path) -> None:
    """Copy the pictures that the commands of a page drew."""
    for match in DRAWN.finditer(page.read_text()):
        source, target = next(folder.rglob(match["file"])), page.parent / match["picture"]
        target.parent.mkdir(exist_ok=True)
        if source.suffix == ".html":
            _photograph(source, target)
        else:
            shutil.copyfile(source, target)


def _photograph(source: Path, target: Path) -> None:
    subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         "--window-size=1100,1100", f"--screenshot={target}", source.as_uri()],
        check=True, capture_output=True,
    )  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:])
