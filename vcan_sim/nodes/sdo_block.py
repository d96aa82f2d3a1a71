"""SDO block transfer (CiA 301 7.2.4.3.8 to 7.2.4.3.16): many segments, one answer, a CRC over all of them."""

from __future__ import annotations

from binascii import crc_hqx
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort

if TYPE_CHECKING:
    from collections.abc import Iterator

SEGMENT = 7  # bytes
BLOCK_SIZE = 127  # segments, the most that CiA 301 allows
LAST, SEQUENCE = 0x80, 0x7F  # of the first byte of a segment


@dataclass(slots=True)
class BlockUpload:
    """An object on its way to the client.

    Attributes:
        data: All bytes of the object.
        block_size: Segments that the client takes before it answers.
        sent: Segments that the client has confirmed.
        offered: Segments of the block under way; 0 before the first.
    """

    data: bytes
    block_size: int
    sent: int = 0
    offered: int = 0

    def segments(self) -> Iterator[bytes]:
        """Yield the segments of the next block."""
        rest = self.data[SEGMENT * self.sent :]
        parts = [rest[start : start + SEGMENT] for start in range(0, len(rest), SEGMENT)]
        self.offered = min(len(parts), self.block_size)
        for number, part in enumerate(parts[: self.offered], start=1):
            last = LAST if number == len(parts) else 0
            yield bytes([number | last]) + part.ljust(SEGMENT, b"\0")

    def confirm(self, received: int, block_size: int) -> bool:
        """Note how many segments of the block came; return whether all of the object has."""
        if received > self.offered:
            raise SdoAbort(Abort.SEQUENCE)
        if not 1 <= block_size <= BLOCK_SIZE:
            raise SdoAbort(Abort.BLOCK_SIZE)
        self.sent, self.block_size = self.sent + received, block_size
        return SEGMENT * self.sent >= len(self.data)

    def end(self) -> bytes:
        """Return the last message: the unused bytes of the last segment, and the CRC."""
        unused = -len(self.data) % SEGMENT
        return bytes([0xC1 | unused << 2]) + crc_hqx(self.data, 0).to_bytes(2, "little")


@dataclass(slots=True)
class BlockDownload:
    """An object on its way from the client.

    Attributes:
        index: Index of the object.
        sub: Sub-index of the object.
        size: Bytes that were announced; None where none were.
        has_crc: Whether the client sends a CRC.
        longest: Bytes after which the transfer is refused.
        data: What has come.
        sequence: Number of the last segment of the block that came in order.
        is_ended: Whether the last segment has come.
    """

    index: int
    sub: int
    size: int | None
    has_crc: bool
    longest: int
    data: bytearray = field(default_factory=bytearray)
    sequence: int = 0
    is_ended: bool = False

    def take(self, segment: bytes) -> bytes | None:
        """Take a segment; return the answer to the block where it ends here."""
        number = segment[0] & SEQUENCE
        if number == self.sequence + 1:
            self.sequence = number
            self.data += segment[1:]
            self.is_ended = bool(segment[0] & LAST)
        if len(self.data) > self.longest:
            raise SdoAbort(Abort.LENGTH)
        if not (segment[0] & LAST or number == BLOCK_SIZE):
            return None
        answer = bytes([0xA2, self.sequence, BLOCK_SIZE])
        self.sequence = 0
        return answer

    def finish(self, request: bytes) -> bytes:
        """Return the object's bytes at the end of the transfer, its length and CRC checked."""
        unused, crc = request[0] >> 2 & 0x07, int.from_bytes(request[1:3], "little")
        data = bytes(self.data[: len(self.data) - unused])
        if self.size is not None and self.size != len(data):
            raise SdoAbort(Abort.LENGTH)
        if self.has_crc and crc != crc_hqx(data, 0):
            raise SdoAbort(Abort.CRC)
        return data
