"""A recording folder from a bus log of any format and a description of the robot."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

from omnimate.files.errors import SourceError
from omnimate.files.logs.frames import FD
from omnimate.files.logs.writing import open_writer, written_whole
from omnimate.files.recordings.folder import LOG, VEHICLE, check_free
from omnimate.vehicle.file import save_vehicle

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.files.logs.blocks import LogStream
    from omnimate.vehicle.parameters import VehicleParameters


def import_log(
    log: LogStream, vehicle: VehicleParameters, folder: Path, progress: Callable[[int, int], None]
) -> int:
    """Write `vehicle.toml` and `can.log`, frame by frame, so that memory does not grow with the log.

    Returns the number of CAN FD frames, which a recording does not hold; `progress` is called with the bytes
    read and their total.

    Raises:
        RecordingError: The folder holds a recording.
        SourceError: The folder cannot be written.
        LogError: The log cannot be read, or `can.log` cannot be written.
    """
    check_free(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        save_vehicle(vehicle, folder / VEHICLE)
    except OSError as error:
        raise SourceError(folder, f"cannot be written: {error.strerror or error}") from error
    fd_frames = 0
    with written_whole(folder / LOG) as partial, closing(open_writer(partial, ".log")) as writer:
        for frame in log.with_progress(progress):
            if frame.flags & FD:
                fd_frames += 1
            else:
                writer.write_frame(frame)
    return fd_frames
