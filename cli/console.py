"""Where the command line writes: results on stdout, progress and problems on stderr."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from rich.console import Console

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rich.text import Text

out = Console(highlight=False, markup=False, emoji=False, soft_wrap=True)  # the terminal wraps lines
err = Console(stderr=True, highlight=False, emoji=False)
PROGRESS_PERIOD = 10.0  # [s] between two lines of progress where there is no terminal
_problems: list[str] = []


class ProgressUpdate(Protocol):
    """The function that updates a progress bar."""

    def __call__(self, done: float, total: float, doing: str | None = None, /) -> None:
        """Show the steps done, the total steps (0 where unknown), and what is being done."""


def say(line: str | Text) -> None:
    """Print a line of results."""
    out.print(line)


def note(line: str) -> None:
    """Print a line on stderr."""
    err.print(line, markup=False, soft_wrap=True)


def print_error(sentence: str) -> None:
    """Print one error sentence."""
    err.print("[bold red]error:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)


def warn(sentence: str) -> None:
    """Print one warning sentence; the exit code does not change."""
    err.print("[bold yellow]warning:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)


def report_problem(sentence: str) -> None:
    """Print a warning about data that were left out; the verb goes on, and its exit code will be 1."""
    _problems.append(sentence)
    warn(sentence)


def take_problems() -> list[str]:
    """Return and clear the problems reported since the last call."""
    taken = _problems.copy()
    _problems.clear()
    return taken


@contextmanager
def progress_bar(doing: str) -> Iterator[ProgressUpdate]:
    """Show a progress bar, or a line now and then where there is no terminal; give what updates it."""
    from rich.progress import Progress

    if not err.is_terminal:
        yield _progress_lines(doing)
        return
    with Progress(console=err, transient=True) as progress:
        task = progress.add_task(doing, total=None)
        yield lambda done, total, doing=None: progress.update(
            task, completed=done, total=total or None, description=doing
        )


def _progress_lines(doing: str) -> ProgressUpdate:
    """Return what prints a line of progress on stderr, at most every `PROGRESS_PERIOD`."""
    due = time.monotonic() + PROGRESS_PERIOD

    def update(done: float, total: float, what: str | None = None, /) -> None:
        nonlocal due
        if time.monotonic() >= due:
            due = time.monotonic() + PROGRESS_PERIOD
            note(f"{what or doing}: {done / total:.0%}" if total else f"{what or doing} ...")

    return update
