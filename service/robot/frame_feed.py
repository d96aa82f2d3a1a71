"""Every frame of the bus, forwarded to the recording of a drive and to clients that read the bus."""

from __future__ import annotations

import contextlib
import queue
from typing import TYPE_CHECKING

from omnimate.files.logs.formats.candump_lines import format_frame
from omnimate.files.logs.frames import Frame

if TYPE_CHECKING:
    from collections.abc import Iterator

    import can

    from omnimate.driver.robot.recorder import Recorder
    from omnimate.vehicle.parameters import VehicleParameters

QUEUED_LINES = 5000  # that a slow reader may be behind; it misses what comes after them


class FrameLines:
    """Forwards frames, as lines of `candump -L`, to everybody who reads them."""

    def __init__(self) -> None:
        self._readers: tuple[queue.Queue[str], ...] = ()

    @property
    def has_readers(self) -> bool:
        """Whether somebody reads."""
        return bool(self._readers)

    def put(self, line: str) -> None:
        """Forward a frame."""
        for reader in self._readers:
            with contextlib.suppress(queue.Full):
                reader.put_nowait(line)

    @contextlib.contextmanager
    def reader(self) -> Iterator[queue.Queue[str]]:
        """Yield a queue that receives every frame as a line of `candump -L`, until the block ends."""
        lines: queue.Queue[str] = queue.Queue(QUEUED_LINES)
        self._readers = (*self._readers, lines)
        try:
            yield lines
        finally:
            self._readers = tuple(reader for reader in self._readers if reader is not lines)


class FrameFeed(FrameLines):
    """Takes the place of the driver's recorder, and forwards what it is given."""

    def __init__(self) -> None:
        super().__init__()
        self.recorder: Recorder | None = None
        self.frames = 0

    def use(self, vehicle: VehicleParameters) -> None:
        """Forward the vehicle parameters, in which the driver has completed the encoders' ranges."""
        if self.recorder is not None:
            self.recorder.use(vehicle)

    def frame(self, at: float, message: can.Message) -> None:
        """Forward a frame that was on the bus at a time [s]; OSError where it cannot be recorded."""
        self.frames += 1
        if self.has_readers:
            self.put(format_frame(Frame(at, message.arbitration_id, bytes(message.data))))
        if self.recorder is not None:
            self.recorder.frame(at, message)
