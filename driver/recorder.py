"""Writes the recording folder while the robot drives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from vehicle.candump import CandumpWriter
from vehicle.errors import RecordingError
from vehicle.file import save_vehicle
from vehicle.folder import LOG, POSES, RUN, VEHICLE, write_poses, write_run
from vehicle.frames import ERROR, EXTENDED, REMOTE
from vehicle.recording import Lap, Poses, Run

if TYPE_CHECKING:
    from collections.abc import Sequence

    import can

    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.recording import Direction


class Recorder:
    """A recording folder that is complete at any moment: a crash costs what was not yet on the bus.

    Attributes:
        folder: of the recording.
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
            folder: that holds no recording yet.
            vehicle: as its owner believes it to be.
            protocol: of `run.toml`, written with the first lap; without one there is no `run.toml`.
            side: of the square [m].

        Raises:
            RecordingError: the folder holds a recording, or cannot be written.
        """
        self.folder = Path(folder)
        self._protocol, self._side = protocol, side
        self._laps: list[Lap] = []
        self._poses: list[tuple[float, TruckName, Sequence[float], Sequence[float]]] = []
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            taken = [name for name in (LOG, f"{LOG}.gz") if (self.folder / name).exists()]
            if taken:
                raise RecordingError(self.folder, f"it holds a recording ({taken[0]}); choose another folder")
            save_vehicle(vehicle, self.folder / VEHICLE)
            self._log = CandumpWriter(self.folder / LOG)
        except OSError as error:
            raise RecordingError(self.folder, f"cannot be written: {error.strerror or error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def use(self, vehicle: VehicleParameters) -> None:
        """Replace `vehicle.toml`, after the encoders have told their ranges."""
        save_vehicle(vehicle, self.folder / VEHICLE)

    def frame(self, at: float, message: can.Message) -> None:
        """Write a frame that was on the bus at a time [s]."""
        flags = (
            message.is_extended_id * EXTENDED
            | message.is_remote_frame * REMOTE
            | message.is_error_frame * ERROR
        )
        self._log.write(at, message.arbitration_id, bytes(message.data), flags=flags, length=message.dlc)

    def lap(self, direction: Direction, start: float, end: float) -> None:
        """Add a lap [s] and write `run.toml`."""
        self._laps.append(Lap(direction, start, end))
        write_run(Run(self._protocol or "free", self._side, tuple(self._laps)), self.folder / RUN)

    def pose(self, at: float, truck: TruckName, pose: Sequence[float], sigma: Sequence[float]) -> None:
        """Add a pose x, y, theta [m, m, rad] with its standard deviations, and write `poses.csv`."""
        self._poses.append((at, truck, pose, sigma))
        times, bodies, poses, sigmas = zip(*self._poses, strict=True)
        table = Poses(
            np.array(times, float), np.array(bodies), np.array(poses, float), np.array(sigmas, float)
        )
        write_poses(table, self.folder / POSES)

    def close(self) -> None:
        """Put everything on disk."""
        self._log.close()

    def discard(self) -> None:
        """Remove what has been written, because no drive came of it."""
        self._log.close()
        for name in (LOG, VEHICLE, POSES, RUN):
            (self.folder / name).unlink(missing_ok=True)
        if not any(self.folder.iterdir()):
            self.folder.rmdir()
