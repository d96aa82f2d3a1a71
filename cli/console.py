"""Where the command line writes: results on stdout, progress and problems on stderr."""

from __future__ import annotations

from rich.console import Console

out = Console(highlight=False, markup=False)
err = Console(stderr=True, highlight=False)


def complain(sentence: str) -> None:
    """Print one error sentence."""
    err.print("[bold red]error:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)


_flaws: list[str] = []


def flaw(sentence: str) -> None:
    """Print a warning about data that were left out; the exit code will be 1 although the rest goes on."""
    _flaws.append(sentence)
    warn(sentence)


def take_flaws() -> list[str]:
    """Return the flaws since the last call, and forget them."""
    taken = _flaws.copy()
    _flaws.clear()
    return taken


def warn(sentence: str) -> None:
    """Print one warning sentence."""
    err.print("[bold yellow]warning:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)
