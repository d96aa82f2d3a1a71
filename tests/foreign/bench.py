"""A bench for foreign devices: python-can's virtual bus, stepped in one thread through a time of its own.

The time passes only while the driver waits for a frame, so that a test is as fast as its code and repeats
exactly.
"""

from __future__ import annotations

import itertools

import can

from omnimate.driver.bus.clock import WallClock
from tests.foreign.devices import ForeignNetwork

STEP = 0.001  # [s] between two looks of the devices at their timers
_numbers = itertools.count()


class BenchClock(WallClock):
    """The driver's wall clock; dialogues with restarted nodes are held between two SYNCs, not in a thread."""

    inline = True


class Bench(can.BusABC):
    """The driver's end of a virtual bus, with the devices at the other end and the time of both.

    Attributes:
        now: The time of the bench [s].
        nodes: Devices by node id.
        sent: Every frame that the driver sent: time, identifier, data.
        heard: Every frame that the driver received: time, identifier, data.
    """

    def __init__(self, nodes):
        self.now = 1000.0
        self.sent, self.heard, self._coming, self._others = [], [], [], []
        channel = f"bench {next(_numbers)}"
        self._near = can.Bus(interface="virtual", channel=channel)
        self.far = can.Bus(interface="virtual", channel=channel)
        self.network = ForeignNetwork(self.far)
        self.network.nodes.clear()
        self.nodes = {node.id: node for node in nodes}
        for node in nodes:
            node.now = self.now
            self.network[node.id] = node
        super().__init__(channel=channel)
        self.channel_info = channel

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
        network = ForeignNetwork(self.far)
        node.now = self.now
        network[node.id] = node
        self._others.append((network, node))

    def at(self, seconds, happen):
        """Let something happen after so long [s]; return when that is [s]."""
        self._coming.append((self.now + seconds, happen))
        return self.now + seconds

    def inject(self, can_id, data, **kwargs):
        """Put a frame on the bus that none of the devices sends."""
        self.far.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False, **kwargs))

    def send(self, msg, timeout=None):
        self.sent.append((self.now, msg.arbitration_id, bytes(msg.data)))
        self._near.send(msg)
        self._step()

    def recv(self, timeout=None):
        end = self.now + (timeout or 0.0)
        while True:
            message = self._near.recv(0.0)
            if message is not None:
                message.timestamp = self.now
                self.heard.append((self.now, message.arbitration_id, bytes(message.data)))
                return message
            if self.now >= end:
                return None
            self.now = min(end, self.now + STEP)
            self._step()

    def _recv_internal(self, timeout):
        raise NotImplementedError  # `recv` does it

    def shutdown(self):
        super().shutdown()
        self._near.shutdown()
        self.far.shutdown()

    def _step(self):
        """Hand the devices what came for them, and let their timers run."""
        while (message := self.far.recv(0.0)) is not None:
            for network in (self.network, *(network for network, _ in self._others)):
                network.notify(message.arbitration_id, message.data, self.now)
        for coming in [coming for coming in self._coming if coming[0] <= self.now]:
            self._coming.remove(coming)
            coming[1]()
        for node in (*self.nodes.values(), *(node for _, node in self._others)):
            node.tick(self.now)
