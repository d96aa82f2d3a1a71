"""Recordings, logs and live buses as the verbs read them; data left out are reported, with exit code 1."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from omnimate.cli.console import report_problem, warn

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator

    from omnimate.files.logs.blocks import LogBlocks, LogReadResult, LogStream
    from omnimate.files.logs.frames import Frame
    from omnimate.files.recordings.folder import LoadedRecording
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording

MAX_PROBLEMS_SHOWN = 20
POLL_PERIOD = 0.2  # [s] after which a silent bus is read again


def load(folder: Path) -> Recording:
    """Return the recording in a folder, after saying what of its log could not be read."""
    from omnimate.files.recordings.folder import read_recording

    loaded = read_recording(folder)
    report_problems(loaded.log.blocks)
    return loaded.recording


def read_drive(
    source: Path,
    vehicle: VehicleParameters | None,
    show_log: Callable[[LogReadResult, VehicleParameters], None] = lambda log, _: report_problems(log.blocks),
) -> LoadedRecording:
    """Return the recording of a folder or a log, with its frames.

    A folder has its own robot, a log needs one. `show_log` is called before the frames become samples.

    Raises:
        RecordingError: No sample of the vehicle is in it.
    """
    from omnimate.files.logs.assemble import assemble
    from omnimate.files.logs.blocks import read_log
    from omnimate.files.recordings.folder import LoadedRecording, read_recording

    if source.is_dir():
        loaded = read_recording(source)
        show_log(loaded.log, vehicle or loaded.recording.vehicle)
        if vehicle is None:
            return loaded
        assembly, log, own = assemble(loaded.log.frames, vehicle, str(source)), loaded.log, loaded.recording
        return LoadedRecording(replace(assembly.recording, poses=own.poses, run=own.run), assembly, log)
    assert vehicle is not None  # the caller has one for a log
    log = read_log(log_of(source))
    show_log(log, vehicle)
    assembly = assemble(log.frames, vehicle, str(source))
    return LoadedRecording(assembly.recording, assembly, log)


def log_of(source: Path) -> Path:
    """Return the path of a log: of a file, of standard input (`-`), or of the log in a recording folder."""
    if not source.is_dir():
        return Path("/dev/stdin") if source == Path("-") else source
    from omnimate.files.recordings.folder import log_path

    return log_path(source)


def report_problems(log: LogBlocks | LogStream) -> None:
    """Say what of a log was left out."""
    for problem in first_problems(log):
        report_problem(problem)


def first_problems(log: LogBlocks | LogStream) -> Iterator[str]:
    """Yield sentences on what of a log was left out, `MAX_PROBLEMS_SHOWN` at most."""
    for number, problem in enumerate(log.problems()):
        if number == MAX_PROBLEMS_SHOWN:
            yield f"{log.source}: and more of the kind"
            break
        yield problem


def frames_on_bus(
    url: str,
    seconds: float | None,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
    *,
    fd: bool = False,
) -> Generator[Frame]:
    """Yield the frames of a live bus until the time is up or the interface fails, which is reported.

    CAN FD only with `fd`; the others are warned of.

    `progress` is called with tenths of a second passed, and of how many; 0 without an end.
    """
    from omnimate.driver.bus.bus import open_bus, receive
    from omnimate.driver.errors import BusLost
    from omnimate.files.logs.formats.python_can_logs import frame_of_message

    start = time.monotonic()
    with open_bus(url) as bus:
        while (rest := POLL_PERIOD if seconds is None else start + seconds - time.monotonic()) > 0.0:
            try:
                message = receive(bus, min(POLL_PERIOD, rest))
            except BusLost as lost:
                report_problem(f"{url}: {lost}")
                return
            progress(int(10.0 * (time.monotonic() - start)), int(10.0 * (seconds or 0.0)))
            frame = None if message is None else frame_of_message(message, fd=fd)
            if isinstance(frame, str):
                warn(f"a frame was left out: {frame}")
            elif frame is not None:
                yield frame
