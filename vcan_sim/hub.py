"""A CAN bus for several processes: a hub that speaks the socketcand protocol over TCP.

What one client sends, all others receive, in one order and with one time; the sender does not
receive its own frames. A simulated vehicle takes part in the hub's own event loop through `Hub.attach`.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from typing import TYPE_CHECKING

import can

from omnimate.vcan_sim.errors import HubError
from omnimate.vcan_sim.hub_client import HubClient
from omnimate.vcan_sim.socketcand import Frame, format_frame

if TYPE_CHECKING:
    from collections.abc import Callable

_MOST_UNREAD = 4 * 1024 * 1024  # [byte]; some 90 thousand frames, or 10 s of the fullest bus


class HubBus(can.BusABC):
    """The hub as a python-can bus, for one participant in the hub's own event loop; it never waits."""

    def __init__(self, hub: Hub, on_frame: Callable[[], None]) -> None:
        self._frames: deque[can.Message] = deque()
        self._hub = hub
        self._on_frame = on_frame
        self.channel_info = f"hub {hub.channel}"
        super().__init__(channel=hub.channel)

    def deliver(self, message: can.Message) -> None:
        """Take a frame from another participant."""
        self._frames.append(message)
        self._on_frame()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        del timeout
        return (self._frames.popleft() if self._frames else None), False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame to all clients."""
        del timeout
        self._hub.broadcast(Frame(msg.arbitration_id, bytes(msg.data), msg.is_extended_id), self)


class Hub:
    """A CAN bus whose participants are TCP clients and buses in the hub's own event loop.

    Attributes:
        channel: Name by which clients open the bus.
        most_unread: Amount of unread data after which a client that does not read is dropped [byte].
        clients: Clients that are connected at the moment.
    """

    def __init__(self, channel: str = "can0", most_unread: int = _MOST_UNREAD) -> None:
        self.channel = channel
        self.most_unread = most_unread
        self.clients: list[HubClient] = []
        self._attached: list[HubBus] = []
        self._server: asyncio.Server | None = None

    async def start(self, host: str, port: int) -> int:
        """Listen; return the port, which the system chooses where `port` is 0.

        Raises:
            HubError: The address cannot be listened on.
        """
        try:
            self._server = await asyncio.get_running_loop().create_server(lambda: HubClient(self), host, port)
        except (OSError, OverflowError) as error:
            raise HubError(host, port, f"cannot listen here ({error}); is another hub running?") from error
        return int(self._server.sockets[0].getsockname()[1])

    async def stop(self) -> None:
        """Close all connections and stop listening."""
        if self._server is not None:
            self._server.close()
        for client in tuple(self.clients):
            client.close()
        if self._server is not None:
            await self._server.wait_closed()
            self._server = None

    def attach(self, on_frame: Callable[[], None]) -> HubBus:
        """Return a bus for a participant in this event loop; `on_frame` is called when a frame has come."""
        bus = HubBus(self, on_frame)
        self._attached.append(bus)
        return bus

    def join(self, client: HubClient) -> None:
        """Add a client that has connected."""
        self.clients.append(client)

    def forget(self, client: HubClient) -> None:
        """Remove a client whose connection has ended."""
        if client in self.clients:
            self.clients.remove(client)

    def broadcast(self, frame: Frame, sender: object) -> None:
        """Give a frame to all participants but its sender."""
        now = time.time()
        data = format_frame(frame, now)
        for client in self.clients:
            if client is not sender:
                client.send(data)
        for bus in self._attached:
            if bus is not sender:
                bus.deliver(
                    can.Message(
                        timestamp=now,
                        arbitration_id=frame.can_id,
                        data=frame.data,
                        is_extended_id=frame.extended,
                    )
                )
