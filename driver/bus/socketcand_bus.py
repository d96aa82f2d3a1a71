"""python-can's socketcand client with the repairs that a busy server and a dying server need."""

from __future__ import annotations

import socket

import can
from can.interfaces.socketcand import SocketCanDaemonBus

ANSWER_TIMEOUT = 2.0  # [s]


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
