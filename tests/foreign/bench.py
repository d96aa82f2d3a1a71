"""A bench for foreign devices: a bus without a medium, stepped in one thread through a time of its own.

The time passes only while the driver waits for a frame, so that a test is as fast as its code and repeats
exactly.
"""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace

import can

from omnimate.driver.bus.clock import WallClock
from tests.foreign.devices import ForeignNetwork

STEP = 0.001  # [s] between two looks of the devices at their timers


class BenchClock(WallClock):
    """The driver's wall clock; dialogues with restarted nodes are held between two SYNCs, not in a thread."""

    inline = True


class Bench(can.BusABC):
    """The driver's end of a bus, with the devices at the other end and the time of both.

    Attributes:
        now: The time of the bench [s].
        nodes: Devices by node id.
        sent: Every frame that the driver sent: time, identifier, data.
        heard: Every frame that the driver received: time, identifier, data.
    """

    def __init__(self, nodes):
        self.now = 1000.0
        self.sent, self.heard, self._coming = [], [], []
        sent = deque()
        self.far = SimpleNamespace(sent=sent, send=sent.append)  # what the devices send is here at once
        self.nodes = {node.id: node for node in nodes}
        self._devices = []
        for node in nodes:
            self.add(node)
        super().__init__(channel="bench")
        self.channel_info = "bench"

    def monotonic(self):
        """Return the time of the bench [s]."""
        return self.now

    def sleep(self, seconds):
        """Let time pass [s]."""
        end = self.now + seconds
        while self.now < end:
            self.now = min(end, self.now + STEP)
            self._step()

    def add(self, node):
        """Put another device on the bus, which may have the node id of one that is there."""
        node.now = self.now
        ForeignNetwork(self.far)[node.id] = node  # of its own: a network has one node of each id
        self._devices.append(node)

    def at(self, seconds, happen):
        """Let something happen after so long [s]; return when that is [s]."""
        self._coming.append((self.now + seconds, happen))
        return self.now + seconds

    def inject(self, can_id, data, **kwargs):
        """Put a frame on the bus that none of the devices sends."""
        self.far.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **kwargs))

    def forget(self):
        """Lose the frames that came for the driver and that it has not received."""
        self.far.sent.clear()

    def send(self, msg, timeout=None):
        self.sent.append((self.now, msg.arbitration_id, bytes(msg.data)))
        for node in self._devices:
            node.network.notify(msg.arbitration_id, msg.data, self.now)
        self._step()

    def recv(self, timeout=None):
        end = self.now + (timeout or 0.0)
        while True:
            if self.far.sent:
                message = self.far.sent.popleft()
                message.timestamp = self.now
                self.heard.append((self.now, message.arbitration_id, bytes(message.data)))
                return message
            if self.now >= end:
                return None
            self.now = min(end, self.now + STEP)
            self._step()

    def _recv_internal(self, timeout):
        raise NotImplementedError  # `recv` does it

    def _step(self):
        """Let happen what is due, and let the timers of the devices run."""
        if self._coming:
            for coming in [coming for coming in self._coming if coming[0] <= self.now]:
                self._coming.remove(coming)
                coming[1]()
        for node in self._devices:
            node.tick(self.now)
