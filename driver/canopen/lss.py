"""The LSS master (CiA 305): finds devices without a node id and gives them one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

MASTER, SLAVE = 0x7E5, 0x7E4  # COB-IDs
NO_ID = 0xFF
SILENCE = 0.04  # [s] to wait for the answer to one question of fastscan: 130 are asked for each device

Identity = tuple[int, int, int, int]  # vendor, product, revision, serial number: 1018h:1 to :4


class Frames(Protocol):
    """Where frames are sent and received."""

    def send(self, can_id: int, data: bytes = b"") -> None:
        """Send a frame."""
        ...

    def drain(self) -> None:
        """Drop the frames that have come."""
        ...

    def await_frame(self, can_id: int, seconds: float | None = None) -> bytes | None:
        """Return the data of the next frame of an identifier, or None where none comes in time."""
        ...


class LssMaster:
    """The one LSS master of a bus; one request at a time."""

    def __init__(self, frames: Frames) -> None:
        self._frames = frames

    def ask(self, request: bytes, seconds: float | None = None) -> bytes | None:
        """Send a request and return the answer of 8 bytes, None where none comes."""
        self._frames.drain()
        self.send(request)
        answer = self._frames.await_frame(SLAVE, seconds)
        return None if answer is None else answer.ljust(8, b"\0")

    def send(self, request: bytes) -> None:
        """Send a request that has no answer."""
        self._frames.send(MASTER, request.ljust(8, b"\0"))

    def leave(self) -> None:
        """Switch all devices back from configuration; one that got its first id boots."""
        self.send(b"\x04\x00")

    def select(self, identity: Sequence[int]) -> bool:
        """Switch the device with an identity to configuration; return whether it answers."""
        self.leave()
        for command, value in zip((0x40, 0x41, 0x42), identity, strict=False):
            self.send(_number(command, value))
        answer = self.ask(_number(0x43, identity[3]))
        return answer is not None and answer[0] == 0x44

    def node_id(self) -> int | None:
        """Return the node id of the device in configuration (`NO_ID`: none); None where it is silent."""
        answer = self.ask(b"\x5e")
        return answer[1] if answer is not None and answer[0] == 0x5E else None

    def identity(self) -> Identity | None:
        """Return the identity of the device in configuration, None where it does not answer."""
        numbers = []
        for command in (0x5A, 0x5B, 0x5C, 0x5D):
            answer = self.ask(bytes([command]))
            if answer is None or answer[0] != command:
                return None
            numbers.append(int.from_bytes(answer[1:5], "little"))
        return numbers[0], numbers[1], numbers[2], numbers[3]

    def configure_id(self, node: int) -> bool:
        """Give the device in configuration a node id for when it leaves; return whether it takes it."""
        return self._is_done(bytes([0x11, node]))

    def store(self) -> bool:
        """Have the device in configuration store its node id."""
        return self._is_done(b"\x17")

    def _is_done(self, request: bytes) -> bool:
        answer = self.ask(request)
        return answer is not None and answer[:2] == bytes([request[0], 0])

    def fastscan(self) -> Identity | None:
        """Return the identity of a device without a node id, now in configuration; None where there is none.

        The bits of the four numbers are asked for one by one (CiA 305, 6.7); of several devices the one with
        the most zeros in front is found.
        """
        if self.ask(b"\x51" + bytes(4) + b"\x80\x00\x00") is None:
            return None
        numbers = []
        for number in range(4):
            value = 0
            for bit in range(31, -1, -1):
                asked = _number(0x51, value) + bytes([bit, number, number])
                value |= (self.ask(asked, SILENCE) is None) << bit
            if self.ask(_number(0x51, value) + bytes([0, number, (number + 1) % 4])) is None:
                return None
            numbers.append(value)
        return numbers[0], numbers[1], numbers[2], numbers[3]


def _number(command: int, value: int) -> bytes:
    return bytes([command]) + value.to_bytes(4, "little")
