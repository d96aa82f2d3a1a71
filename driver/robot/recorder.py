"""Writes the recording folder while the robot drives."""

from __future__ import annotations

import contextlib
import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from omnimate.files.logs.formats.candump_writer import CandumpWriter
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, Frame
from omnimate.files.recordings.folder import LOG, POSES, RUN, VEHICLE, check_free
from omnimate.files.recordings.poses_csv import write_poses
from omnimate.files.recordings.run_toml import write_run
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import save_vehicle
from omnimate.vehicle.recording import Lap, Poses, Run

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import can

    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.recording import Direction


def frame_flags(message: can.Message) -> int:
    """Return the sum of EXTENDED, REMOTE and ERROR of `files.logs.frames`, where they apply."""
    return (
        message.is_extended_id * EXTENDED | message.is_remote_frame * REMOTE | message.is_error_frame * ERROR
    )


class Recorder:
    """A recording folder that is complete at any moment: a crash costs the last half second at most.

    Where the disk refuses, as one that is full, frames are left out until it takes them again. Other files
    that it refuses are written with the next of them, or by `close`.
    """

    def __init__(
        self,
        folder: Path | str,
        vehicle: VehicleParameters,
        *,
        protocol: str | None = None,
        side: float | None = None,
    ) -> None:
        """Make the folder, write `vehicle.toml`, and open `can.log`.

        Args:
            folder: Folder that holds no recording yet; it is made where it does not exist.
            vehicle: Vehicle as its owner believes it to be.
            protocol: Protocol in `run.toml`, which is written with the first lap; `free` where it is None.
            side: Side of the square [m]; None where there is none.

        Raises:
            RecordingError: The folder holds a recording, or cannot be written.
        """
        self.folder = Path(folder)
        self._protocol, self._side = protocol, side
        self._laps: list[Lap] = []
        self._latest = -math.inf
        self._unsaved: dict[str, Callable[[Path], None]] = {}
        self._poses: list[tuple[float, TruckName, Sequence[float], Sequence[float]]] = []
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            check_free(self.folder)
            save_vehicle(vehicle, self.folder / VEHICLE)
            self._log = CandumpWriter(self.folder / LOG)
        except OSError as error:
            raise RecordingError(self.folder, f"cannot be written: {error.strerror or error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def use(self, vehicle: VehicleParameters) -> None:
        """Replace `vehicle.toml`, after the encoders have reported their ranges."""
        self._save(VEHICLE, partial(save_vehicle, vehicle))

    def frame(self, at: float, message: can.Message) -> None:
        """Write a frame that was on the bus at time `at` [s], or with the frame before where that is later.

        Frames come in the order in which they were on the bus; two threads may take their times in another.
        CAN FD frames are none of CANopen's, and are left out.

        Raises:
            OSError: The disk refuses; the frame is left out.
        """
        if message.is_fd:
            return
        self._latest = max(at, self._latest)
        data, flags = bytes(message.data), frame_flags(message)
        self._log.write_frame(Frame(self._latest, message.arbitration_id, data, flags, message.dlc))

    def lap(self, direction: Direction, start: float, end: float) -> None:
        """Add a lap from `start` to `end` [s] and write `run.toml`."""
        self._laps.append(Lap(direction, start, end))
        self._save(RUN, partial(write_run, Run(self._protocol or "free", self._side, tuple(self._laps))))

    def pose(self, at: float, truck: TruckName, pose: Sequence[float], sigma: Sequence[float]) -> None:
        """Add an absolute pose x, y, theta [m, m, rad] at a time [s] and write `poses.csv`.

        An unknown standard deviation in `sigma` [m, m, rad] is nan.
        """
        self._poses.append((at, truck, pose, sigma))
        times, bodies, poses, sigmas = zip(*self._poses, strict=True)
        table = Poses(
            np.array(times, float), np.array(bodies), np.array(poses, float), np.array(sigmas, float)
        )
        self._save(POSES, partial(write_poses, table))

    def close(self) -> None:
        """Write everything to disk and close the log.

        Raises:
            RecordingError: The disk refuses the end of the recording; what it took before is there.
        """
        try:
            try:
                self._log.close()
            finally:
                self._save_all()
        except OSError as error:
            raise RecordingError(
                self.folder, f"its end cannot be written: {error.strerror or error}"
            ) from error

    def discard(self) -> None:
        """Remove what has been written, because nothing was driven."""
        with contextlib.suppress(OSError):
            self._log.close()
        for name in (LOG, VEHICLE, POSES, RUN):
            (self.folder / name).unlink(missing_ok=True)
        if not any(self.folder.iterdir()):
            self.folder.rmdir()

    def _save(self, name: str, write: Callable[[Path], None]) -> None:
        """Write a file of the folder, now or later."""
        self._unsaved[name] = write
        with contextlib.suppress(OSError):
            self._save_all()

    def _save_all(self) -> None:
        for name, write in tuple(self._unsaved.items()):
            write(self.folder / name)
            del self._unsaved[name]
