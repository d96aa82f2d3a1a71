"""Every frame of the bus, for the recording that is being made and for those who look on."""

from __future__ import annotations

import contextlib
import queue
from typing import TYPE_CHECKING

from vehicle.candump_lines import format_frame
from vehicle.frames import Frame

if TYPE_CHECKING:
    from collections.abc import Iterator

    import can

    from driver.recorder import Recorder
    from vehicle.parameters import VehicleParameters

WAITING = 5000  # frames that a slow reader may be behind


class Tap:
    """What the driver takes for its recorder.

    Attributes:
        recorder: of the drive that is going on; None between drives.
        frames: so far.
    """

    def __init__(self) -> None:
        self.recorder: Recorder | None = None
        self.frames = 0
        self._readers: tuple[queue.Queue[str], ...] = ()

    def use(self, vehicle: VehicleParameters) -> None:
        """Hand the encoders' ranges on."""
        if self.recorder is not None:
            self.recorder.use(vehicle)

    def frame(self, at: float, message: can.Message) -> None:
        """Hand a frame on that was on the bus at a time [s]."""
        self.frames += 1
        if self.recorder is not None:
            self.recorder.frame(at, message)
        if self._readers:
            line = format_frame(Frame(at, message.arbitration_id, bytes(message.data)))
            for reader in self._readers:
                with contextlib.suppress(queue.Full):
                    reader.put_nowait(line)

    @contextlib.contextmanager
    def reader(self) -> Iterator[queue.Queue[str]]:
        """Yield a queue that gets every frame as a line of `candump -L`."""
        mine: queue.Queue[str] = queue.Queue(WAITING)
        self._readers = (*self._readers, mine)
        try:
            yield mine
        finally:
            self._readers = tuple(one for one in self._readers if one is not mine)
