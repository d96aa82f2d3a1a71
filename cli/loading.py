"""Recordings as the verbs take them: what had to be left out is said, and makes the exit code 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.cli.console import report_problem
from omnimate.cli.errors import CallError

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.files.logs.blocks import LogBlocks
    from omnimate.files.logs.reading import LogReadResult
    from omnimate.files.logs.streaming import LogStream
    from omnimate.vehicle.recording import Recording

MOST_PROBLEMS = 20  # shown


def load(folder: Path) -> Recording:
    """Return the recording in a folder, after saying what of its log could not be read."""
    from omnimate.files.recordings.folder import read_recording

    loaded = read_recording(folder)
    report_problems(loaded.log)
    return loaded.recording


def log_of(source: Path) -> Path:
    """Return a log that was given, or the log in a recording folder that was.

    Raises:
        CallError: The URL of a bus was given.
    """
    if ":/" in str(source) and not source.exists():
        url = str(source).replace(":/", "://", 1)
        raise CallError(f"{url} is not a log; a bus is given as --bus {url}")
    if not source.is_dir():
        return source
    from omnimate.files.recordings.folder import log_path

    return log_path(source)


def report_problems(log: LogReadResult | LogBlocks | LogStream) -> None:
    """Say what of a log was left out."""
    for number, problem in enumerate(log.problems()):
        if number == MOST_PROBLEMS:
            report_problem(f"{log.source}: and more of the kind")
            break
        report_problem(problem)
