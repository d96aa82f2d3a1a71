"""Recordings as the verbs take them: what had to be left out is said, and makes the exit code 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cli.console import flaw
from vehicle.folder import read_recording

if TYPE_CHECKING:
    from pathlib import Path

    from vehicle.logs import LogReadResult
    from vehicle.recording import Recording

MOST_PROBLEMS = 20  # shown


def load(folder: Path) -> Recording:
    """Return the recording in a folder, after saying what of its log could not be read."""
    loaded = read_recording(folder)
    tell_problems(loaded.log)
    return loaded.recording


def tell_problems(log: LogReadResult) -> None:
    """Say what of a log was left out."""
    for number, problem in enumerate(log.problems()):
        if number == MOST_PROBLEMS:
            flaw(f"{log.source}: and more of the kind")
            break
        flaw(problem)
