"""Opens a bus from its URL; where no server answers, that is an error within seconds.

Three interfaces of python-can have repairs: SocketCAN with hardware stamps, socketcand, a fast virtual bus.
"""

from __future__ import annotations

import logging
import queue
import socket
import struct
import time
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import can
from can.interfaces.socketcan import SocketcanBus
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.virtual import VirtualBus, channels_lock

from omnimate.driver.bus.adapters import BusUrl, open_adapter
from omnimate.driver.errors import BusError, BusLost, in_one_line

if TYPE_CHECKING:
    from collections.abc import Callable

SO_TIMESTAMPING = 37  # asm-generic/socket.h; also the type of the control message
SO_TIMESTAMPNS = 35
# linux/net_tstamp.h
RX_HARDWARE, RX_SOFTWARE, SOFTWARE, RAW_HARDWARE = 1 << 2, 1 << 3, 1 << 4, 1 << 6
_TIMESPEC = struct.Struct("@ll")  # seconds, nanoseconds
_BUFFER = socket.CMSG_SPACE(3 * _TIMESPEC.size)
ANSWER_TIMEOUT = 2.0  # [s] to wait for socketcand's answer to a request


class StampedSocket(socket.socket):
    """A socket whose `recvmsg` returns the adapter's time stamp instead of the kernel's.

    Linux gives three stamps with a frame (Documentation/networking/timestamping.rst): the kernel's, an
    obsolete one, and the adapter's. python-can reads the control message of one stamp only, so that the best
    of them is put into that message.
    """

    @classmethod
    def take_over(cls, plain: socket.socket) -> socket.socket:
        """Return a socket with the adapter's stamps instead of an open one, or that one if it has none."""
        try:
            plain.setsockopt(
                socket.SOL_SOCKET, SO_TIMESTAMPING, RX_HARDWARE | RX_SOFTWARE | SOFTWARE | RAW_HARDWARE
            )
        except OSError:
            return plain
        plain.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 0)
        family, kind, protocol, blocking = plain.family, plain.type, plain.proto, plain.gettimeout()
        stamped = cls(family, kind, protocol, fileno=plain.detach())
        stamped.settimeout(blocking)
        return stamped

    def recvmsg(self, bufsize: int, ancbufsize: int = 0, flags: int = 0) -> tuple[bytes, Any, int, Any]:
        """Receive as `socket.recvmsg`, with one time stamp of the kind SO_TIMESTAMPNS."""
        data, controls, flags, address = super().recvmsg(bufsize, max(ancbufsize, _BUFFER), flags)
        stamps = [content for level, kind, content in controls if (level, kind) == _STAMPS]
        stamp = _best(stamps[0]) if stamps else _TIMESPEC.pack(*divmod(time.time_ns(), 10**9))
        return data, [(socket.SOL_SOCKET, SO_TIMESTAMPNS, stamp)], flags, address


_STAMPS = (socket.SOL_SOCKET, SO_TIMESTAMPING)


def _best(stamps: bytes) -> bytes:
    """Return the adapter's stamp, or the kernel's where the adapter gave none."""
    software, hardware = stamps[: _TIMESPEC.size], stamps[2 * _TIMESPEC.size : 3 * _TIMESPEC.size]
    return hardware if any(hardware) else software


class RobustSocketcandBus(SocketCanDaemonBus):
    """A socketcand client that loses no frame while it connects, and notices that the server is gone."""

    @property
    def _socket(self) -> socket.socket:
        # The base class keeps its socket private; there is no other way to see that the server is gone.
        return vars(self)["_SocketCanDaemonBus__socket"]  # type: ignore[no-any-return]  # from vars()

    def _expect_msg(self, msg: str) -> None:
        """Read the answer and not one byte of the frames that may follow it in the same segment."""
        self._socket.settimeout(ANSWER_TIMEOUT)
        answer = b""
        while not answer.endswith(b">") and (byte := self._socket.recv(1)):
            answer += byte
        self._socket.settimeout(None)
        if answer.decode("ascii", "replace") != msg:
            self._socket.close()
            raise can.CanInitializationError(f"expected {msg!r}, got {answer!r}")

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        """Raise where the server has closed the connection; the base class goes on to return None."""
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


class FastVirtualBus(VirtualBus):
    """A virtual bus on the same channels as python-can's own.

    python-can makes a deep copy of every frame and limits the length of its queue; the driver needs neither.
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
                received = copy(msg)
                received.timestamp, received.data, received.is_rx = stamp, bytearray(msg.data), True
                receiver.put(received, timeout=timeout)


PROBE_TIMEOUT = 2.0  # [s] to wait for a server's greeting
DEFAULT_PORT = 29536  # of socketcand, by its README
DEFAULT_BITRATE = 500_000  # [bit/s] in the advice for an interface that is down

# python-can writes every incomplete TCP segment as a warning; what matters is raised or counted here.
logging.getLogger("can").addHandler(logging.NullHandler())


def open_bus(url: str, bitrate: int | None = None) -> can.BusABC:
    """Return the bus that a URL names.

    Args:
        url: `interface://channel?key=value` with any interface of python-can and its keys, such as
            `socketcan://can0`, `socketcand://host:port/can0`, `slcan:///dev/ttyACM0@500000`,
            `virtual://name`, `pcan://PCAN_USBBUS1?bitrate=250000&sample_point=87.5`.
        bitrate: Bit rate where the URL has none and the interface needs one [bit/s].

    Raises:
        BusError: There is no such interface or key, nothing answers, or the interface refuses.
    """
    try:
        parts = BusUrl.of(url)
        opener = _OPENERS.get(parts.interface)
        return open_adapter(parts, bitrate) if opener is None else opener(parts, bitrate)
    except (can.CanError, OSError, ValueError, TypeError) as error:
        raise BusError(
            url, f"cannot be opened: {in_one_line(error)}; check the URL, and that the adapter is connected"
        ) from error


def receive(bus: can.BusABC, timeout: float) -> can.Message | None:
    """Return the next frame of a bus, None after `timeout` [s]; raises BusLost where the interface fails."""
    try:
        return bus.recv(timeout)
    except (can.CanError, OSError) as error:
        raise BusLost(error) from error


def _virtual(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    if url.options:
        return open_adapter(url, None)
    return FastVirtualBus(channel=url.channel or "omnimate")


def _socketcan(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    rate = url.options.get("bitrate", DEFAULT_BITRATE)
    up = f"ip link set {url.channel or 'can0'} up type can bitrate {rate}"
    if url.channel not in {name for _, name in socket.if_nameindex()}:
        raise BusError(
            url.text,
            f"no network interface {url.channel!r}; expected a CAN interface that is up: {up}",
        )
    if "bitrate" in url.options:
        raise BusError(url.text, f"Linux sets the bit rate of socketcan, not this URL; use {up}")
    bus = open_adapter(url, None)
    if isinstance(bus, SocketcanBus):
        bus.socket = StampedSocket.take_over(bus.socket)
    return bus


def _slcan(url: BusUrl, bitrate: int | None) -> can.BusABC:
    device, _, rate = url.channel.partition("@")
    options = {"bitrate": int(rate)} if rate else {}
    return open_adapter(replace(url, channel=device, options=options | dict(url.options)), bitrate)


def _socketcand(url: BusUrl, _bitrate: int | None) -> can.BusABC:
    parts = urlsplit(f"//{url.channel}")
    host, port = parts.hostname, parts.port or DEFAULT_PORT
    if host is None:
        raise BusError(url.text, "no host; expected socketcand://host:port/can0")
    _probe(url.text, host, port)
    channel = parts.path.strip("/") or "can0"
    try:
        return RobustSocketcandBus(channel=channel, host=host, port=port, tcp_tune=True)  # type: ignore[no-untyped-call]  # python-can
    except can.CanError as error:
        raise BusError(
            url.text, f"the server refuses channel {channel!r} ({error}); expected a channel that it serves"
        ) from error


def _probe(url: str, host: str, port: int) -> None:
    """Check that a socketcand server greets; python-can would spin for ten seconds, or wait without end."""
    try:
        with socket.create_connection((host, port), timeout=PROBE_TIMEOUT) as probe:
            probe.settimeout(PROBE_TIMEOUT)
            greeting = probe.recv(16)
    except OSError as error:
        raise BusError(
            url, f"no answer from {host} port {port} ({error}); is the socketcand server running there?"
        ) from error
    if not greeting.startswith(b"< hi"):
        raise BusError(
            url,
            f"{host} port {port} does not speak socketcand; expected '< hi', got {greeting!r}: "
            "check host and port",
        )


_OPENERS: dict[str, Callable[[BusUrl, int | None], can.BusABC]] = {
    "virtual": _virtual,
    "socketcan": _socketcan,
    "socketcand": _socketcand,
    "slcan": _slcan,
}
