"""A log that is replayed: as a bus on which nothing can be sent, or onto a bus."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import can

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.errors import BusError, BusLost
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.frames import ERROR

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.files.logs.frames import Frame


class LogBus(can.BusABC):
    """The frames of a log, one after the other, with the times of the log, until it has `ended`."""

    def __init__(self, frames: Iterable[Frame], pace: float = 1.0) -> None:
        """Begin with the first frame now; the frames, in order, come `pace` times faster than recorded."""
        super().__init__("log")
        self.channel_info = "log"
        self.pace = pace
        self._frames = iter(frames)
        self._next = next(self._frames, None)
        self.ended = self._next is None
        self._first = self._last = 0.0 if self._next is None else self._next.time
        self._began = time.monotonic()

    def now(self) -> float:
        """Return the time in the log [s]: not beyond the next frame, however late it is received."""
        if self._next is None:
            return self._last
        return min(self._next.time, self._due())

    def _due(self) -> float:
        """Return up to which time in the log its frames are to be received by now [s]."""
        return self._first + (time.monotonic() - self._began) * self.pace

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        """Return the next frame when its time has come, or None after the time-out."""
        frame = self._next
        ahead = math.inf if frame is None else (frame.time - self._due()) / self.pace
        if timeout is not None and ahead > timeout:
            time.sleep(timeout)
            return None, False
        if frame is None:
            return None, False
        if ahead > 0.0:
            time.sleep(ahead)
        self._last = frame.time
        self._next = next(self._frames, None)
        self.ended = self._next is None
        return message_of_frame(frame), False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:  # noqa: ARG002 -- python-can's
        """Refuse: a log cannot be changed."""
        raise BusError("log", f"{msg.arbitration_id:03X}h cannot be sent: a log is only replayed")


def send_frames(frames: Iterable[Frame], url: str, pace: float = 1.0) -> None:
    """Send frames onto a bus at a multiple of their recorded pace; error frames are left out.

    Args:
        frames: The frames in the order of their times.
        url: URL of the bus.
        pace: How many times faster than recorded; 0 sends them at once.

    Raises:
        BusError: The bus cannot be opened.
        BusLost: The interface fails.
    """
    with open_bus(url) as bus:
        began, first = time.monotonic(), None
        for frame in frames:
            if frame.flags & ERROR:
                continue
            first = frame.time if first is None else first
            ahead = (frame.time - first) / pace - (time.monotonic() - began) if pace else 0.0
            if ahead > 0.0:
                time.sleep(ahead)
            try:
                bus.send(message_of_frame(frame), timeout=1.0)
            except (can.CanError, OSError) as error:
                raise BusLost(error) from error
