"""A CAN bus for several processes: a hub that speaks the socketcand protocol over TCP.

A frame of one client is sent to all others, in one order and with one time stamp, and not back to its
sender. A simulated vehicle takes part in the hub's own event loop through `Hub.attach`.
"""

from __future__ import annotations

import asyncio
import logging
import socket
import time
from collections import deque
from typing import TYPE_CHECKING

import can

from omnimate.vcan_sim.errors import HubError, ProtocolError
from omnimate.vcan_sim.socketcand import CommandReader, format_frame, parse_send

if TYPE_CHECKING:
    from collections.abc import Callable

_log = logging.getLogger(__name__)

# [s] without frames after the last `< ok >`, which python-can must read alone (assumption)
_START_DELAY = 0.1
_MAX_UNREAD = 4 * 1024 * 1024  # [byte] about 90 000 frames, or 10 s of a fully loaded bus of 1 Mbit/s


class HubBus(can.BusABC):
    """The hub as a python-can bus, for one participant in the hub's event loop; no call blocks."""

    def __init__(self, hub: Hub, on_frame: Callable[[], None]) -> None:
        self._frames: deque[can.Message] = deque()
        self._hub = hub
        self._on_frame = on_frame
        self.channel_info = f"hub {hub.channel}"
        super().__init__(channel=hub.channel)

    def deliver(self, message: can.Message) -> None:
        """Receive a frame of another participant."""
        self._frames.append(message)
        self._on_frame()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        del timeout
        return (self._frames.popleft() if self._frames else None), False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame to all clients."""
        del timeout
        self._hub.broadcast(msg, self)


class HubClient(asyncio.Protocol):
    """One TCP client: the dialogue that opens the bus, then frames in both directions."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._reader = CommandReader()
        self._transport: asyncio.WriteTransport | None = None
        self._outbox: list[bytes] = []
        self._flush_due: asyncio.TimerHandle | asyncio.Handle | None = None
        self._answers: dict[str, Callable[[], None]] = {f"open {hub.channel}": self._open, "echo": self._echo}
        self._raw = False
        self.name = "?"

    # asyncio.Protocol

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Send the greeting; asyncio has switched Nagle's algorithm off (TCP_NODELAY)."""
        assert isinstance(transport, asyncio.WriteTransport)  # it is a TCP connection
        self._transport = transport
        self.name = str(transport.get_extra_info("peername"))
        self._hub.join(self)
        transport.write(b"< hi >")

    def data_received(self, data: bytes) -> None:
        """Execute the client's commands; a malformed one ends the connection."""
        self._acknowledge()
        try:
            for command in self._reader.feed(data):
                self._execute(command)
        except ProtocolError as error:
            self._refuse(error)

    def _acknowledge(self) -> None:
        """Acknowledge at once if the system has TCP_QUICKACK, which must be set for each acknowledgement.

        A client with Nagle's algorithm delays a frame until the previous one is acknowledged, up to 40 ms
        later. python-can's player has then closed its connection, and its last frame is lost.
        """
        if self._transport is not None and hasattr(socket, "TCP_QUICKACK"):
            connection = self._transport.get_extra_info("socket")
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)

    def connection_lost(self, _exc: Exception | None) -> None:
        """Remove the client from the hub."""
        self._transport = None
        self._hub.leave(self)

    # The dialogue

    def _execute(self, command: str) -> None:
        if self._raw:
            message = parse_send(command)
            if message is None:
                _log.warning("client %s: remote frames do not pass the socketcand protocol", self.name)
                return
            self._hub.broadcast(message, self)
            self._flush()  # a client that sends frames has read the last `< ok >`
        else:
            self._answer(command)

    def _answer(self, command: str) -> None:
        answer = self._answers.get(" ".join(command.split()))
        if answer is None:
            expected = " or ".join(f"< {word} >" for word in self._answers)
            raise ProtocolError(command, f"expected {expected}")
        answer()

    def _write(self, data: bytes) -> None:
        if self._transport is not None:
            self._transport.write(data)

    def _echo(self) -> None:
        self._write(b"< echo >")

    def _open(self) -> None:
        self._answers = {"rawmode": self._start, "echo": self._echo}
        self._write(b"< ok >")

    def _start(self) -> None:
        self._raw = True
        self._write(b"< ok >")
        self._flush_due = asyncio.get_running_loop().call_later(_START_DELAY, self._flush)

    def _refuse(self, error: ProtocolError) -> None:
        _log.warning("client %s: %s", self.name, error)
        self._write(f"< error {error.problem} >".encode("ascii", errors="replace"))
        self.close()

    # Frames

    def send(self, data: bytes) -> None:
        """Send a frame, together with others of the same iteration of the event loop."""
        if self._raw and self._transport is not None:
            self._outbox.append(data)
            if self._flush_due is None:
                self._flush_due = asyncio.get_running_loop().call_soon(self._flush)

    def _flush(self) -> None:
        if self._flush_due is not None:
            self._flush_due.cancel()
            self._flush_due = None
        if self._transport is None or not self._outbox:
            return
        self._transport.write(b"".join(self._outbox))
        self._outbox.clear()
        if self._transport.get_write_buffer_size() > self._hub.max_unread:
            _log.warning("client %s reads too slowly and is dropped; frames were lost for it", self.name)
            self._transport.abort()
            self._transport = None

    def close(self) -> None:
        """Send the waiting frames, then end the connection."""
        self._flush()
        if self._transport is not None:
            self._transport.close()
            self._transport = None


class Hub:
    """A CAN bus whose participants are TCP clients and buses in the hub's own event loop.

    Clients open it as `channel`. One that leaves `max_unread` bytes unread is dropped.
    """

    def __init__(self, channel: str = "can0", max_unread: int = _MAX_UNREAD) -> None:
        self.channel = channel
        self.max_unread = max_unread
        self.clients: list[HubClient] = []
        self._attached: list[HubBus] = []
        self._server: asyncio.Server | None = None

    async def start(self, host: str, port: int) -> int:
        """Listen; return the port, which the system chooses if `port` is 0; raises HubError."""
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
        """Return a bus for a participant in this event loop; `on_frame` is called for each received frame."""
        bus = HubBus(self, on_frame)
        self._attached.append(bus)
        return bus

    def join(self, client: HubClient) -> None:
        """Add a client that has connected."""
        self.clients.append(client)

    def leave(self, client: HubClient) -> None:
        """Remove a client whose connection has ended."""
        if client in self.clients:
            self.clients.remove(client)

    def broadcast(self, message: can.Message, sender: object) -> None:
        """Set the time stamp of a frame, and send it to all participants except its sender."""
        message.timestamp = time.time()
        data = format_frame(message)
        for client in self.clients:
            if client is not sender:
                client.send(data)
        for bus in self._attached:
            if bus is not sender:
                bus.deliver(message)
