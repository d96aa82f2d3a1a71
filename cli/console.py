"""Where the command line writes: results on stdout, progress and problems on stderr."""

from __future__ import annotations

from rich.console import Console

out = Console(highlight=False, markup=False)
err = Console(stderr=True, highlight=False)


def complain(sentence: str) -> None:
    """Print one error sentence."""
    err.print("[bold red]error:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)


def warn(sentence: str) -> None:
    """Print one warning sentence."""
    err.print("[bold yellow]warning:[/] ", end="")
    err.print(sentence, markup=False, soft_wrap=True)
