"""Sends the frames of a log onto a bus again."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from omnimate.driver.bus.bus import open_bus
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.frames import ERROR

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from omnimate.files.logs.frames import Frame


def send_frames(
    frames: Iterable[Frame],
    url: str,
    pace: float = 1.0,
    *,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Send frames onto a bus at a multiple of their recorded pace; error frames are left out.

    Args:
        frames: The frames in the order of their times.
        url: URL of the bus.
        pace: How many times faster than recorded; 0 sends them at once.
        clock: Returns the time [s].
        sleep: Waits for a time [s].

    Raises:
        BusError: The bus cannot be opened.
    """
    with open_bus(url) as bus:
        began, first = clock(), None
        for frame in frames:
            if frame.flags & ERROR:
                continue
            first = frame.time if first is None else first
            ahead = (frame.time - first) / pace - (clock() - began) if pace else 0.0
            if ahead > 0.0:
                sleep(ahead)
            bus.send(message_of_frame(frame), timeout=1.0)
