"""python-can interfaces with repairs: SocketCAN with hardware stamps, socketcand, a fast virtual bus."""

from __future__ import annotations

import queue
import socket
import struct
import time
from copy import copy
from typing import Any

import can
from can.interfaces.socketcand import SocketCanDaemonBus
from can.interfaces.virtual import VirtualBus, channels_lock

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
