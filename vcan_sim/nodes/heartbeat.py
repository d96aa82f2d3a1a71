"""Heartbeats: produced by 1017h, supervised by 1016h; node guarding (CiA 301 7.2.8.3.2, 7.2.8.3.1)."""

from __future__ import annotations

import math


class HeartbeatProducer:
    """Timing of the heartbeats of this device: the next is `due` [s]; inf while 1017h is 0."""

    def __init__(self) -> None:
        self.due = math.inf
        self._period = 0.0

    def configure(self, milliseconds: int, now: float) -> None:
        """Take over 1017h; the first heartbeat comes after one period."""
        self._period = milliseconds * 1e-3
        self.due = now + self._period if milliseconds else math.inf

    def sent(self, now: float) -> None:
        """Schedule the next heartbeat one period after the last due time; after a missed period, from now."""
        late = now - self.due
        self.due = self.due + self._period if late < self._period else now + self._period


class HeartbeatConsumer:
    """Supervision of one other node, from its first heartbeat on: the next is `due` [s], or inf."""

    def __init__(self) -> None:
        self.due = math.inf
        self._node = 0
        self._period = 0.0

    def configure(self, value: int) -> None:
        """Take over 1016h:1: node id in bits 16 to 23, time [ms] in bits 0 to 15."""
        self._node, self._period = value >> 16 & 0x7F, (value & 0xFFFF) * 1e-3
        self.due = math.inf

    def receive(self, node: int, now: float) -> bool:
        """Receive a heartbeat; return whether it is from the supervised node."""
        if node != self._node or not self._period:
            return False
        self.due = now + self._period
        return True


class NodeGuarding:
    """Answers to the master's remote frames, and supervision of these: the next is `due` [s], or inf."""

    def __init__(self) -> None:
        self.due = math.inf
        self._life_time = 0.0
        self._toggle = 0

    def configure(self, guard_time: int, factor: int) -> None:
        """Take over 100Ch [ms] and 100Dh; the life time begins with the first remote frame."""
        self._life_time = guard_time * factor * 1e-3
        self.due = math.inf

    def reset(self) -> None:
        """Begin with toggle bit 0, as after a reset."""
        self._toggle, self.due = 0, math.inf

    def answer(self, state: int, now: float) -> bytes:
        """Return the answer to a remote frame in an NMT state."""
        self.due = now + self._life_time if self._life_time else math.inf
        data = bytes([state | self._toggle])
        self._toggle ^= 0x80
        return data
