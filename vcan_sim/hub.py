"""A CAN bus for several processes: a hub that speaks the socketcand protocol over TCP.

What one client sends, all others receive, in one order and with one time; the sender does not
receive its own frames. A simulated vehicle takes part in the hub's own event loop through `Hub.attach`.
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
from omnimate.vcan_sim.socketcand import CommandReader, Frame, format_frame, parse_send

if TYPE_CHECKING:
    from collections.abc import Callable

_log = logging.getLogger(__name__)

_GRACE = 0.1  # [s]; python-can wants the last `< ok >` alone in one read, so frames wait that long
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


class HubClient(asyncio.Protocol):
    """One TCP client: the dialogue that opens the bus, then frames in both directions.

    Attributes:
        name: Address of the client, for messages.
    """

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
        """Greet; asyncio has switched Nagle's algorithm off (TCP_NODELAY)."""
        assert isinstance(transport, asyncio.WriteTransport)  # it is a TCP connection
        self._transport = transport
        self.name = str(transport.get_extra_info("peername"))
        self._hub.join(self)
        transport.write(b"< hi >")

    def data_received(self, data: bytes) -> None:
        """Follow the client's commands; one that is malformed ends the connection."""
        self._acknowledge()
        try:
            for command in self._reader.feed(data):
                self._follow(command)
        except ProtocolError as error:
            self._refuse(error)

    def _acknowledge(self) -> None:
        """Acknowledge at once, where the system can; it does so once for each time that it is asked.

        Clients that leave Nagle's algorithm on hold a frame back until the one before is acknowledged,
        40 ms later; python-can's player has closed its connection by then, and its last frame is lost.
        """
        if self._transport is not None and hasattr(socket, "TCP_QUICKACK"):
            connection = self._transport.get_extra_info("socket")
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)

    def connection_lost(self, _exc: Exception | None) -> None:
        """Forget the client."""
        self._transport = None
        self._hub.forget(self)

    # The dialogue

    def _follow(self, command: str) -> None:
        if self._raw:
            frame = parse_send(command)
            if frame is None:
                _log.warning("client %s: remote frames do not pass the socketcand protocol", self.name)
                return
            self._hub.broadcast(frame, self)
            self._flush()  # it has read our last `< ok >`
        else:
            self._shake_hands(command)

    def _shake_hands(self, command: str) -> None:
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
        self._flush_due = asyncio.get_running_loop().call_later(_GRACE, self._flush)

    def _refuse(self, error: ProtocolError) -> None:
        _log.warning("client %s: %s", self.name, error)
        self._write(f"< error {error.problem} >".encode("ascii", errors="replace"))
        self.close()

    # Frames

    def send(self, data: bytes) -> None:
        """Send a frame, together with others that come in the same round of the event loop."""
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
        if self._transport.get_write_buffer_size() > self._hub.most_unread:
            _log.warning("client %s reads too slowly and is dropped; frames were lost for it", self.name)
            self._transport.abort()
            self._transport = None

    def close(self) -> None:
        """Send what waits, then end the connection."""
        self._flush()
        if self._transport is not None:
            self._transport.close()
            self._transport = None


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
