"""python-can's virtual bus without what costs more than all the rest."""

from __future__ import annotations

import queue
import time

import can
from can.interfaces.virtual import VirtualBus, channels_lock


class FastVirtualBus(VirtualBus):
    """A virtual bus on the same channels as python-can's own.

    python-can makes a deep copy of every frame and limits the length of its queue; the driver needs neither.

    Args:
        channel: Name of the channel.
    """

    def __init__(self, channel: str) -> None:
        super().__init__(channel=channel)
        with channels_lock:
            self.channel.remove(self.queue)
            self.queue = queue.SimpleQueue()  # type: ignore[assignment]  # what is used of it is the same
            self.channel.append(self.queue)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a copy of the frame to all other buses on the channel."""
        self._check_if_open()
        stamp = time.time()
        for receiver in self.channel:
            if receiver is not self.queue:
                receiver.put(_copy(msg, stamp), timeout=timeout)


def _copy(message: can.Message, stamp: float) -> can.Message:
    return can.Message(
        timestamp=stamp,
        arbitration_id=message.arbitration_id,
        is_extended_id=message.is_extended_id,
        is_remote_frame=message.is_remote_frame,
        is_error_frame=message.is_error_frame,
        is_fd=message.is_fd,
        bitrate_switch=message.bitrate_switch,
        dlc=message.dlc,
        data=bytearray(message.data),
    )
