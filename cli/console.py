"""Where the command line writes: results on stdout, progress and problems on stderr."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from rich.console import Console

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rich.text import Text

out = Console(highlight=False, markup=False, emoji=False, soft_wrap=True)  # the terminal wraps lines
err = Console(stderr=True, highlight=False, markup=False, emoji=False)
PROGRESS_PERIOD = 10.0  # [s] between two lines of progress where there is no terminal
REFRESH = 0.25  # [s] between two updates of a status line
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
    err.print(line, soft_wrap=True)


def print_error(sentence: str) -> None:
    """Print one error sentence."""
    err.print("error: ", style="bold red", end="")
    err.print(sentence, soft_wrap=True)


def warn(sentence: str) -> None:
    """Print one warning sentence; the exit code does not change."""
    err.print("warning: ", style="bold yellow", end="")
    err.print(sentence, soft_wrap=True)


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
    is_due = _every(PROGRESS_PERIOD)

    def update(done: float, total: float, what: str | None = None, /) -> None:
        if is_due():
            note(f"{what or doing}: {done / total:.0%}" if total else f"{what or doing} ...")

    return update


@contextmanager
def status_line() -> Iterator[Callable[[Callable[[], str]], None]]:
    """Show a line on stderr, or one now and then where there is no terminal.

    Given is what updates it by a function that returns the words, which is called where they are shown.
    """
    from rich.live import Live
    from rich.text import Text

    is_due = _every(REFRESH if err.is_terminal else PROGRESS_PERIOD)
    if not err.is_terminal:
        yield lambda words: note(words()) if is_due() else None
        return
    with Live(console=err, transient=True, auto_refresh=False) as live:
        yield lambda words: live.update(Text(words()), refresh=True) if is_due() else None


def _every(period: float) -> Callable[[], bool]:
    """Return a function that says whether a period [s] has passed since it said so, or since now."""
    due = time.monotonic() + period

    def is_due() -> bool:
        nonlocal due
        if time.monotonic() < due:
            return False
        due = time.monotonic() + period
        return True

    return is_due
