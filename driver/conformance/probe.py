"""Raw frames to one node and what it answers, for checks that a well-behaved client never makes."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

import can

from omnimate.driver.bus.bus import receive
from omnimate.driver.errors import BusLost, DriverError
from omnimate.files.logs.canopen_words import HEARTBEAT, NMT_ID, SDO_ANSWER, SDO_REQUEST

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

BOOT_TIMEOUT = 5.0  # [s] from a reset to the boot-up frame
MAX_DRAINED = 1000  # frames, so that draining ends on a full bus too; 127 devices answer a question at most
SETTLING = 0.05  # [s] after an NMT command, to which there is no answer (CiA 301, 7.2.8)
ABORT = 0x80  # first byte of an SDO abort
# SDO abort codes (CiA 301, 7.2.4)
WRONG_TOGGLE, WRONG_COMMAND, WRONG_CRC = 0x05030000, 0x05040001, 0x05040004
UNSUPPORTED_ACCESS, READ_ONLY, NO_OBJECT, NO_SUBINDEX = 0x06010000, 0x06010002, 0x06020000, 0x06090011
NOT_MAPPABLE, PDO_TOO_LONG, INCOMPATIBLE = 0x06040041, 0x06040042, 0x06040043
WRONG_LENGTH = (0x06070010, 0x06070012, 0x06070013)  # wrong, too long, too short
INVALID_VALUE, VALUE_TOO_HIGH = 0x06090030, 0x06090031
NOT_STORED, LOCAL_CONTROL, DEVICE_STATE = 0x08000020, 0x08000021, 0x08000022


class Reply(NamedTuple):
    """A frame that was received."""

    time: float  # time on the probe's clock [s]
    can_id: int  # 11-bit identifier
    data: bytes


class ConformanceError(DriverError):
    """A device that does not do what a standard asks for."""


class AbsentError(DriverError):
    """An object or a service that a standard leaves to the device, and that it does not have."""


class AbortedError(DriverError):
    """An SDO transfer that the device aborted with `code`."""

    def __init__(self, index: int, subindex: int, code: int) -> None:
        super().__init__(f"{index:04X}h:{subindex:02X} aborted with {code:08X}h")
        self.code = code


class Probe:
    """One node of a bus, seen by raw frames, whose answers must come within `timeout` [s]."""

    def __init__(
        self, bus: can.BusABC, node: int, timeout: float = 0.5, clock: Callable[[], float] | None = None
    ) -> None:
        self.node, self.timeout = node, timeout
        self._bus, self._clock = bus, clock or time.monotonic

    def send(self, can_id: int, data: bytes = b"", *, remote: bool = False) -> None:
        """Send a frame; a remote one asks for one byte; raises BusLost."""
        frame = can.Message(
            arbitration_id=can_id, data=None if remote else data, dlc=1 if remote else None,
            is_remote_frame=remote, is_extended_id=False,
        )  # fmt: skip
        try:
            self._bus.send(frame)
        except (can.CanError, OSError) as error:
            raise BusLost(error) from error

    def listen(self, seconds: float, until: Callable[[Reply], bool] = lambda _reply: False) -> list[Reply]:
        """Return the frames of the next seconds, or up to the first frame for which `until` holds.

        Raises BusLost.
        """
        end, replies = self._clock() + seconds, list[Reply]()
        while True:
            message = receive(self._bus, max(0.0, end - self._clock()))
            if message is not None and not (message.is_extended_id or message.is_error_frame):
                replies.append(Reply(self._clock(), message.arbitration_id, bytes(message.data)))
                if until(replies[-1]):
                    return replies
            if self._clock() >= end:
                return replies

    def drain(self) -> None:
        """Drop all frames that have come: several devices may have answered a question."""
        for _ in range(MAX_DRAINED):
            if not self.listen(0.0):
                break

    def heard(self, can_id: int, seconds: float) -> list[Reply]:
        """Return the frames of one identifier that come in so many seconds."""
        return [reply for reply in self.listen(seconds) if reply.can_id == can_id]

    def await_frame(self, can_id: int, seconds: float | None = None) -> bytes | None:
        """Return the data of the next frame of an identifier, or None where none comes in time."""
        replies = self.listen(self.timeout if seconds is None else seconds, lambda r: r.can_id == can_id)
        return replies[-1].data if replies and replies[-1].can_id == can_id else None

    # SDO

    def send_sdo(self, request: bytes) -> None:
        """Send an SDO request as it is, without waiting for its answer."""
        self.send(SDO_REQUEST + self.node, request)

    def await_sdo(self) -> bytes | None:
        """Return the next SDO answer of the node, None where none comes in time."""
        return self.await_frame(SDO_ANSWER + self.node)

    def ask(self, request: bytes) -> bytes | None:
        """Send an SDO request as it is and return the answer, None where none comes."""
        self.listen(0.0)  # what is left of the check before
        self.send_sdo(request)
        return self.await_sdo()

    def dialogue(self, index: int, subindex: int, command: int, data: bytes = b"") -> bytes:
        """Send an SDO request about an object and return the answer; raises AbortedError.

        Raises ConformanceError without an answer, or for one of another length or about another object.
        """
        head = index.to_bytes(2, "little") + bytes([subindex])
        answer = self.ask((bytes([command]) + head + data).ljust(8, b"\0"))
        what = f"{index:04X}h:{subindex:02X}"
        if answer is None:
            raise ConformanceError(f"no answer to SDO about {what}")
        if len(answer) != 8:
            raise ConformanceError(f"an SDO answer of {len(answer)} bytes about {what}; expected 8")
        if answer[0] == ABORT:
            raise AbortedError(index, subindex, int.from_bytes(answer[4:], "little"))
        if answer[1:4] != head:
            raise ConformanceError(f"an answer about {answer[1:4].hex()} to a request about {head.hex()}")
        return answer

    def read(self, index: int, subindex: int = 0) -> bytes:
        """Return an object's bytes, by an expedited or segmented upload; errors as of `dialogue`."""
        answer = self.dialogue(index, subindex, 0x40)
        if answer[0] & 0x02:
            return answer[4 : 8 - (answer[0] >> 2 & 3)] if answer[0] & 0x01 else answer[4:]
        data, toggle = b"", 0
        while True:
            part = self.segment(bytes([0x60 | toggle]).ljust(8, b"\0"))
            if part[0] & 0xF0 != toggle:
                raise ConformanceError(f"segment answer {part[0]:02X}h; expected toggle bit {toggle:02X}h")
            data += part[1 : 8 - (part[0] >> 1 & 7)]
            toggle ^= 0x10
            if part[0] & 0x01:
                return data

    def segment(self, request: bytes) -> bytes:
        """Send a request that names no object and return the answer; errors as of `dialogue`."""
        answer = self.ask(request)
        if answer is None or len(answer) != 8:
            raise ConformanceError(f"no answer of 8 bytes to SDO request {request.hex()}")
        if answer[0] == ABORT:
            about = int.from_bytes(answer[1:3], "little"), answer[3]
            raise AbortedError(*about, int.from_bytes(answer[4:], "little"))
        return answer

    def write(self, index: int, subindex: int, value: int, size: int) -> None:
        """Write a number of so many bytes by an expedited download; errors as of `dialogue`."""
        data = (value % (1 << 8 * size)).to_bytes(size, "little")
        self.dialogue(index, subindex, 0x23 | (4 - size) << 2, data)

    def find(self, index: int, subindex: int = 0) -> int | None:
        """Return an object as a number, None where the device aborts; errors else as of `dialogue`."""
        try:
            return int.from_bytes(self.read(index, subindex), "little")
        except AbortedError:
            return None

    def need(self, index: int, subindex: int = 0) -> int:
        """Return an object as a number; raises AbsentError, or ConformanceError without an answer."""
        value = self.find(index, subindex)
        if value is None:
            raise AbsentError(f"no {index:04X}h:{subindex:02X}")
        return value

    def refusal(self, index: int, subindex: int, value: int, size: int) -> int | None:
        """Write a number and return the abort code, None where the device takes it."""
        try:
            self.write(index, subindex, value, size)
        except AbortedError as aborted:
            return aborted.code
        return None

    @contextmanager
    def restoring(self, *objects: tuple[int, int, int]) -> Iterator[None]:
        """Write objects (index, subindex, bytes) back at the end, in order, except those that are absent."""
        before = [(*place, self.find(*place[:2])) for place in objects]
        try:
            yield
        finally:
            for index, subindex, size, value in before:
                if value is not None:
                    self.refusal(index, subindex, value, size)

    # NMT

    def nmt(self, command: int) -> None:
        """Send an NMT command to the node."""
        self.send(NMT_ID, bytes([command, self.node]))
        self.listen(SETTLING)

    def heartbeats(self, seconds: float) -> list[Reply]:
        """Return the heartbeats and boot-ups of the node that come in so many seconds."""
        return self.heard(HEARTBEAT + self.node, seconds)

    def guard(self) -> bytes | None:
        """Ask for the state by node guarding and return the answer's data, None where none comes."""
        self.listen(0.0)
        self.send(HEARTBEAT + self.node, remote=True)
        return self.await_frame(HEARTBEAT + self.node)

    def reset(self, command: int) -> None:
        """Reset the node and wait for its boot-up; raises ConformanceError where there is none in time."""
        self.listen(0.0)
        self.send(NMT_ID, bytes([command, self.node]))
        boot = self.await_frame(HEARTBEAT + self.node, BOOT_TIMEOUT)
        if boot != b"\0":
            received = "nothing" if boot is None else boot.hex()
            raise ConformanceError(
                f"{received} on {HEARTBEAT + self.node:03X}h after a reset; expected boot-up 00"
            )


def expect(condition: object, problem: str) -> None:
    """Raise ConformanceError with a problem unless a condition holds."""
    if not condition:
        raise ConformanceError(problem)


def expect_code(code: int | None, *expected: int) -> None:
    """Raise ConformanceError unless a device refused with one of these SDO abort codes."""
    wanted = " or ".join(f"{value:08X}h" for value in expected)
    found = "accepted" if code is None else f"aborted with {code:08X}h"
    expect(code in expected, f"{found}; expected abort {wanted}")
