"""Recordings are read in a separate process, whose memory and time are limited."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimate.files.recordings.folder import load_recording
from omnimate.service.errors import InvalidValueError, TooLargeError
from omnimate.service.jobs.process import running

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.recording import Recording

MEMORY_LIMIT = 2_000_000_000  # [bytes]; 5 million frames take half of it
READ_TIMEOUT = 120.0  # [s]; 5 million frames take 4 s


def read_in_process(
    root: Path, folder: Path, memory: int = MEMORY_LIMIT, timeout: float = READ_TIMEOUT
) -> Recording:
    """Return the recording in a folder; messages name its files as they are seen from `root`.

    Raises:
        InvalidValueError: the recording cannot be read.
        TooLargeError: it takes too much memory [bytes] or time [s].
    """
    end = time.monotonic() + timeout
    place = str(root), str(folder.relative_to(root))
    with running("recording", _read, *place, memory=memory, niceness=0) as process:  # a client waits for it
        outcome = process.outcome(lambda _message: time.monotonic() < end)
    if outcome is None:
        raise TooLargeError(f"this recording was not read within {timeout:g} s; cut it into shorter ones")
    if "limit" in outcome:
        raise TooLargeError(f"{outcome['error']}; cut it into shorter ones")
    if "error" in outcome:
        raise InvalidValueError("recording", outcome["error"])
    if "recording" not in outcome:
        raise TooLargeError(f"this recording cannot be read: {outcome['died']}; cut it into shorter ones")
    recording: Recording = outcome["recording"]
    return recording


def load_relative(root: str, folder: str, source: str) -> Recording:
    """Return the recording in a folder of `root`, where this process then works.

    Errors name its files relative to `root`, so that they do not reveal paths of this machine.
    """
    os.chdir(root)
    return replace(load_recording(Path(folder)), source=source)


def _read(_report: Callable[[float, str], None], root: str, folder: str) -> dict[str, Any]:
    return {"recording": load_relative(root, folder, folder)}
