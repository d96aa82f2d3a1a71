"""A bus from its URL, with an answer within seconds where nobody is there."""

from __future__ import annotations

import importlib.util
import logging
import queue
import socket
import time
from typing import TYPE_CHECKING
from urllib.parse import SplitResult, urlsplit

import can
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.virtual import VirtualBus, channels_lock

from driver.errors import BusError

if TYPE_CHECKING:
    from collections.abc import Callable

PROBE_TIMEOUT = 2.0  # [s]
DEFAULT_PORT = 29536  # of socketcand
DEFAULT_BITRATE = 500_000
SCHEMES = "virtual://name, socketcan://can0, socketcand://host:port/can0, slcan:///dev/ttyACM0@500000"

# python-can writes every incomplete TCP segment as a warning; what matters is raised or counted here.
logging.getLogger("can").addHandler(logging.NullHandler())


def open_bus(url: str) -> can.BusABC:
    """Return the bus that a URL names.

    Raises:
        BusError: unknown scheme, nobody answers, or the interface refuses; it says what to do.
    """
    try:
        parts = urlsplit(url)
        opener = _OPENERS.get(parts.scheme)
        if opener is None:
            raise BusError(url, f"unknown scheme {parts.scheme!r}; expected one of {SCHEMES}")
        return opener(url, parts)
    except (can.CanError, OSError, ValueError) as error:
        raise BusError(url, f"cannot be opened: {error}") from error


def _virtual(_url: str, parts: SplitResult) -> can.BusABC:
    return _VirtualBus(channel=parts.netloc or parts.path.lstrip("/") or "omnimate")


def _socketcan(url: str, parts: SplitResult) -> can.BusABC:
    if parts.netloc not in {name for _, name in socket.if_nameindex()}:
        raise BusError(
            url,
            f"no network interface {parts.netloc!r}; expected a CAN interface that is up: "
            f"ip link set {parts.netloc or 'can0'} up type can bitrate {DEFAULT_BITRATE}",
        )
    return can.Bus(interface="socketcan", channel=parts.netloc)


def _slcan(url: str, parts: SplitResult) -> can.BusABC:
    if importlib.util.find_spec("serial") is None:
        raise BusError(url, "slcan needs pyserial: pip install 'omnimate[slcan]'")
    device, _, bitrate = (parts.netloc + parts.path).partition("@")
    return can.Bus(interface="slcan", channel=device, bitrate=int(bitrate or DEFAULT_BITRATE))


def _socketcand(url: str, parts: SplitResult) -> can.BusABC:
    host, port = parts.hostname, parts.port or DEFAULT_PORT
    if host is None:
        raise BusError(url, "no host; expected socketcand://host:port/can0")
    _probe(url, host, port)
    channel = parts.path.strip("/") or "can0"
    try:
        return _SocketcandBus(channel=channel, host=host, port=port, tcp_tune=True)  # type: ignore[no-untyped-call]  # python-can
    except can.CanError as error:
        raise BusError(url, f"the server refuses channel {channel!r}: {error}") from error


def _probe(url: str, host: str, port: int) -> None:
    """Ask whether a socketcand server greets; python-can would spin for ten seconds, or wait for ever."""
    try:
        with socket.create_connection((host, port), timeout=PROBE_TIMEOUT) as probe:
            probe.settimeout(PROBE_TIMEOUT)
            greeting = probe.recv(16)
    except OSError as error:
        raise BusError(
            url, f"nobody answers at {host} port {port} ({error}); is the socketcand server running there?"
        ) from error
    if not greeting.startswith(b"< hi"):
        raise BusError(url, f"{host} port {port} does not speak socketcand (it says {greeting!r})")


class _VirtualBus(VirtualBus):
    """python-can's virtual bus, and on the same channels, without what costs more than all the rest.

    That is a deep copy of every frame, and a queue that is bounded, for which it has no use.
    """

    def __init__(self, channel: str) -> None:
        super().__init__(channel=channel)
        with channels_lock:
            self.channel.remove(self.queue)
            self.queue = queue.SimpleQueue()  # type: ignore[assignment]  # what is used of it is the same
            self.channel.append(self.queue)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Hand a copy of the frame to everybody else on the channel."""
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
        dlc=message.dlc,
        data=bytearray(message.data),
    )


class _SocketcandBus(SocketCanDaemonBus):
    """python-can's client with two repairs, which a busy and a dying server need."""

    @property
    def _socket(self) -> socket.socket:
        # The base class keeps its socket private; there is no other way to see that the server is gone.
        return vars(self)["_SocketCanDaemonBus__socket"]  # type: ignore[no-any-return]  # from vars()

    def _expect_msg(self, msg: str) -> None:
        """Read the answer and not one byte of the frames that may follow it in the same segment."""
        self._socket.settimeout(PROBE_TIMEOUT)
        answer = b""
        while not answer.endswith(b">") and (byte := self._socket.recv(1)):
            answer += byte
        self._socket.settimeout(None)
        if answer.decode("ascii", "replace") != msg:
            self._socket.close()
            raise can.CanInitializationError(f"expected {msg!r}, got {answer!r}")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        """Raise where the server has closed the connection; the base class returns None for ever."""
        message, filtered = super()._recv_internal(timeout)  # type: ignore[no-untyped-call]  # python-can
        if message is None and self._closed_by_server():
            raise can.CanOperationError("the socketcand server closed the connection")
        return message, filtered

    def _closed_by_server(self) -> bool:
        try:
            return self._socket.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT) == b""
        except BlockingIOError:
            return False
        except OSError:
            return True


_OPENERS: dict[str, Callable[[str, SplitResult], can.BusABC]] = {
    "virtual": _virtual,
    "socketcan": _socketcan,
    "socketcand": _socketcand,
    "slcan": _slcan,
}
