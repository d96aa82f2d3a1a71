"""Recordings are read in a process of their own, whose memory and time are limited."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnimate.files.recordings.folder import load_recording
from omnimate.service.errors import InvalidValueError, TooLargeError
from omnimate.service.jobs.process import running

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.recording import Recording

MEMORY = 2_000_000_000  # [bytes]; 5 million frames take half of it
PATIENCE = 120.0  # [s]; 5 million frames take 4 s


def read_in_process(place: Path, folder: Path, memory: int = MEMORY, patience: float = PATIENCE) -> Recording:
    """Return the recording in a folder; messages name its files as they are seen from `place`.

    Raises:
        InvalidValueError: the recording cannot be read.
        TooLargeError: it takes too much memory [bytes] or time [s].
    """
    end = time.monotonic() + patience
    with running("recording", _read, str(place), str(folder.relative_to(place)), memory) as process:
        outcome = process.outcome(lambda _message: time.monotonic() < end)
    if outcome is None:
        raise TooLargeError(f"this recording was not read within {patience:g} s; cut it into shorter ones")
    if "error" in outcome:
        raise InvalidValueError("recording", outcome["error"])
    if "recording" not in outcome:
        raise TooLargeError(f"this recording cannot be read: {outcome['died']}; cut it into shorter ones")
    recording: Recording = outcome["recording"]
    return recording


def load_relative(place: str, folder: str, source: str) -> Recording:
    """Return the recording in a folder of `place`, where this process then works.

    Errors name its files without the place, which is nobody's business outside of this machine.
    """
    os.chdir(place)
    return replace(load_recording(Path(folder)), source=source)


def _read(_report: Callable[[float, str], None], place: str, folder: str, memory: int) -> dict[str, Any]:
    with suppress(ImportError):  # Windows has no such limit
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    try:
        return {"recording": load_relative(place, folder, folder)}
    except MemoryError:
        return {"died": f"it takes more than {memory / 1e6:g} MB of memory"}
