"""One TCP client of the hub, in the socketcand protocol."""

from __future__ import annotations

import asyncio
import logging
import socket
from typing import TYPE_CHECKING, Protocol

from omnimate.vcan_sim.errors import ProtocolError
from omnimate.vcan_sim.socketcand import CommandReader, parse_send

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vcan_sim.socketcand import Frame

_log = logging.getLogger(__name__)

_GRACE = 0.1  # [s]; python-can wants the last `< ok >` alone in one read, so frames wait that long


class Bus(Protocol):
    """What a client needs of its hub.

    Attributes:
        channel: Name by which clients open the bus.
        most_unread: Amount of unread data after which a client is dropped [byte].
    """

    channel: str
    most_unread: int

    def join(self, client: HubClient) -> None:
        """Add a client that has connected."""

    def forget(self, client: HubClient) -> None:
        """Remove a client whose connection has ended."""

    def broadcast(self, frame: Frame, sender: object) -> None:
        """Give a frame to all participants but its sender."""


class HubClient(asyncio.Protocol):
    """One TCP client: the dialogue that opens the bus, then frames in both directions.

    Attributes:
        name: Address of the client, for messages.
    """

    def __init__(self, hub: Bus) -> None:
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
