"""A virtual bus on which a simulated vehicle answers in the thread that listens: no thread, no chance.

Both ends are python-can's virtual bus, so anything else in the process may join the same channel. What
differs is speed: python-can hands each message on by `deepcopy`, which takes most of a drive's time.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import can
from can.interfaces.virtual import VirtualBus

if TYPE_CHECKING:
    from collections.abc import Callable


class QuickBus(VirtualBus):
    """A virtual bus that copies the fields of a message instead of its whole object."""

    def __init__(self, channel: str) -> None:
        """Join the virtual channel of this name."""
        super().__init__(channel=channel)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a message to everybody else on the channel.

        Raises:
            CanOperationError: the bus has been shut down.
        """
        self._check_if_open()
        now = time.time()
        for queue in self.channel:
            if queue is not self.queue:
                queue.put(_copy(msg, now, self.channel_id), timeout=timeout)


class LockstepBus(QuickBus):
    """A virtual bus that lets others answer before it waits.

    Whoever reads from it advances the simulated vehicle as far as the frames on the bus allow. Every
    answer is there when it is looked for, so that a run repeats exactly and nothing waits for a thread.

    Attributes:
        answer: lets the others on this bus take what waits for them; returns how many frames they took.
    """

    def __init__(self, channel: str) -> None:
        """Join the virtual channel of this name."""
        super().__init__(channel)
        self.answer: Callable[[], int] = lambda: 0

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self.queue.empty():
            self.answer()
        return super()._recv_internal(timeout)


def _copy(message: can.Message, now: float, channel: object) -> can.Message:
    """Return a message as another end receives it."""
    return can.Message(
        timestamp=now,
        arbitration_id=message.arbitration_id,
        is_extended_id=message.is_extended_id,
        is_remote_frame=message.is_remote_frame,
        is_error_frame=message.is_error_frame,
        channel=channel,  # type: ignore[arg-type]  # python-can's own virtual bus gives any object
        dlc=message.dlc,
        data=bytes(message.data),
        is_rx=True,
    )
