"""Time stamps of the adapter on a SocketCAN socket, where its driver has them, else those of the kernel."""

from __future__ import annotations

import socket
import struct
import time
from typing import Any

SO_TIMESTAMPING = 37  # asm-generic/socket.h; also the type of the control message
SO_TIMESTAMPNS = 35
# linux/net_tstamp.h
RX_HARDWARE, RX_SOFTWARE, SOFTWARE, RAW_HARDWARE = 1 << 2, 1 << 3, 1 << 4, 1 << 6
_TIMESPEC = struct.Struct("@ll")  # seconds, nanoseconds
_BUFFER = socket.CMSG_SPACE(3 * _TIMESPEC.size)


class StampedSocket(socket.socket):
    """A socket whose `recvmsg` gives the adapter's time stamp in the place of the kernel's.

    Linux gives three stamps with a frame (Documentation/networking/timestamping.rst): the kernel's, an
    obsolete one, and the adapter's. python-can asks for one and knows its control message only; so that is
    what it gets.
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
