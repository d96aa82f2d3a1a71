"""The SDO server of a device: expedited, segmented and block transfers (CiA 301 7.2.4)."""

from __future__ import annotations

import struct
from binascii import crc_hqx
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

_HEADER = struct.Struct("<BHB")
_ABORT = struct.Struct("<BHBL")
_MAX_DOWNLOAD = 64  # [byte] longer than any object of the simulated devices
SEGMENT = 7  # [byte] of data in a segment
BLOCK_SIZE = 127  # segments in a block, the maximum of CiA 301
LAST, SEQUENCE = 0x80, 0x7F  # bits of the first byte of a segment


@dataclass(slots=True)
class _Transfer:
    """The current segmented transfer."""

    index: int
    sub: int
    upload: bool
    size: int | None = None  # bytes that a download has announced
    buffer: bytearray = field(default_factory=bytearray)
    toggle: int = 0


@dataclass(slots=True)
class BlockUpload:
    """A block upload: an object sent to the client."""

    data: bytes  # all bytes of the object
    block_size: int  # segments that the client takes before it answers
    sent: int = 0  # segments that the client has confirmed
    offered: int = 0  # segments of the present block; 0 before the first

    def segments(self) -> Iterator[bytes]:
        """Yield the segments of the next block."""
        rest = self.data[SEGMENT * self.sent :]
        parts = [rest[start : start + SEGMENT] for start in range(0, len(rest), SEGMENT)]
        self.offered = min(len(parts), self.block_size)
        for number, part in enumerate(parts[: self.offered], start=1):
            last = LAST if number == len(parts) else 0
            yield bytes([number | last]) + part.ljust(SEGMENT, b"\0")

    def confirm(self, received: int, block_size: int) -> bool:
        """Confirm the segments of a block that were received; return whether the object is complete."""
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
    """A block download: an object received from the client."""

    index: int
    sub: int
    size: int | None  # bytes that were announced; None where none were
    has_crc: bool  # whether the client sends a CRC
    longest: int  # maximum number of bytes; a longer transfer is refused
    # bytes received so far, with the unused ones of the last segment
    data: bytearray = field(default_factory=bytearray)
    sequence: int = 0  # number of the last segment of the block that came in order
    is_ended: bool = False  # whether the last segment has come

    def take(self, segment: bytes) -> bytes | None:
        """Process a segment; return the answer at the end of a block, else None."""
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
        """Return the object's bytes at the end of the transfer; raise SdoAbort for a wrong length or CRC."""
        unused, crc = request[0] >> 2 & 0x07, int.from_bytes(request[1:3], "little")
        data = bytes(self.data[: len(self.data) - unused])
        if self.size is not None and self.size != len(data):
            raise SdoAbort(Abort.LENGTH)
        if self.has_crc and crc != crc_hqx(data, 0):
            raise SdoAbort(Abort.CRC)
        return data


class SdoServer:
    """Answers the requests of one client."""

    def __init__(
        self,
        read: Callable[[int, int], bytes],
        write: Callable[[int, int, bytes], None],
        size: Callable[[int, int], int | None],
    ) -> None:
        self._read, self._write, self._size = read, write, size
        self._transfer: _Transfer | None = None
        self._upload_block: BlockUpload | None = None
        self._download_block: BlockDownload | None = None
        self._object: Sequence[int] = (0, 0)  # index and sub-index of the current transfer, for an abort
        self._handlers: dict[int, Callable[[bytes], Iterable[bytes]]] = {
            0: self._download_segment,
            1: self._download,
            2: self._upload,
            3: self._upload_segment,
            5: self._block_upload,
            6: self._block_download,
        }

    def reset(self) -> None:
        """Cancel the current transfer."""
        self._transfer = self._upload_block = self._download_block = None

    def answers(self, request: bytes) -> tuple[bytes, ...]:
        """Return the answers to a request: none to an abort or invalid length, several for a block upload."""
        if len(request) != 8 or request[0] == 0x80:
            self.reset()
            return ()
        try:
            return tuple(answer.ljust(8, b"\0") for answer in self._process(request))
        except SdoAbort as abort:
            self.reset()
            return (_ABORT.pack(0x80, *self._object, abort.code),)

    def _process(self, request: bytes) -> Iterable[bytes]:
        block = self._download_block
        if block is not None and not block.is_ended:
            answer = block.take(request)
            return () if answer is None else (answer,)
        specifier = request[0] >> 5
        if specifier == 4:  # an abort with unused bits set
            self.reset()
            return ()
        if not self._continues(specifier, request[0]):
            self.reset()
            _, *self._object = _HEADER.unpack_from(request)
        step = self._handlers.get(specifier)
        if step is None:
            raise SdoAbort(Abort.COMMAND)
        return step(request)

    def _continues(self, specifier: int, command: int) -> bool:
        """Return whether a request continues the current transfer, and so has no index."""
        if specifier in {0, 3}:
            return self._transfer is not None
        if specifier == 5:
            return bool(command & 0x03) and self._upload_block is not None
        return specifier == 6 and bool(command & 0x01) and self._download_block is not None

    # Expedited and segmented

    def _upload(self, request: bytes) -> Iterable[bytes]:
        _, index, sub = _HEADER.unpack_from(request)
        data = self._data_of(index, sub)
        if len(data) <= 4:
            return (_HEADER.pack(0x43 | (4 - len(data)) << 2, index, sub) + data,)
        self._transfer = _Transfer(index, sub, upload=True, buffer=bytearray(data))
        return (_HEADER.pack(0x41, index, sub) + len(data).to_bytes(4, "little"),)

    def _data_of(self, index: int, sub: int) -> bytes:
        data = self._read(index, sub)
        if not data:
            raise SdoAbort(Abort.NO_DATA)
        return data

    def _upload_segment(self, request: bytes) -> Iterable[bytes]:
        transfer = self._current_transfer(request, upload=True)
        part = bytes(transfer.buffer[:7])
        del transfer.buffer[:7]
        last = not transfer.buffer
        head = (request[0] & 0x10) | (7 - len(part)) << 1 | last
        self._transfer = None if last else transfer
        return (bytes([head]) + part,)

    def _download(self, request: bytes) -> Iterable[bytes]:
        command, index, sub = _HEADER.unpack_from(request)
        if command & 0x02:
            size = 4 - (command >> 2 & 0x03) if command & 0x01 else self._size(index, sub) or 4
            self._write(index, sub, request[4 : 4 + size])
        else:
            self._read(index, sub)  # an object that is not there is refused before its data come
            announced = int.from_bytes(request[4:], "little") if command & 0x01 else None
            self._transfer = _Transfer(index, sub, upload=False, size=announced)
        return (_HEADER.pack(0x60, index, sub),)

    def _download_segment(self, request: bytes) -> Iterable[bytes]:
        transfer = self._current_transfer(request, upload=False)
        transfer.buffer += request[1 : 8 - (request[0] >> 1 & 0x07)]
        if len(transfer.buffer) > _MAX_DOWNLOAD:
            raise SdoAbort(Abort.LENGTH)
        if request[0] & 0x01:
            if transfer.size not in {None, len(transfer.buffer)}:
                raise SdoAbort(Abort.LENGTH)
            self._transfer = None
            self._write(transfer.index, transfer.sub, bytes(transfer.buffer))
        return (bytes([0x20 | (request[0] & 0x10)]),)

    def _current_transfer(self, request: bytes, *, upload: bool) -> _Transfer:
        """Return the current transfer; raise SdoAbort for another direction or a wrong toggle bit."""
        transfer = self._transfer
        if transfer is None or transfer.upload is not upload:
            raise SdoAbort(Abort.COMMAND)
        if request[0] & 0x10 != transfer.toggle:
            raise SdoAbort(Abort.TOGGLE)
        transfer.toggle ^= 0x10
        return transfer

    # Block

    def _block_upload(self, request: bytes) -> Iterable[bytes]:
        step = request[0] & 0x03
        if step == 0:
            return self._begin_block_upload(request)
        block = self._upload_block
        if block is None:
            raise SdoAbort(Abort.COMMAND)
        if step == 1:  # the client has everything
            self._upload_block = None
            return ()
        if step == 2 and block.confirm(request[1], request[2]):
            return (block.end(),)
        return tuple(block.segments())

    def _begin_block_upload(self, request: bytes) -> Iterable[bytes]:
        _, index, sub = _HEADER.unpack_from(request)
        data, block_size, threshold = self._data_of(index, sub), request[4], request[5]
        if len(data) <= threshold:
            return self._upload(request)
        if not 1 <= block_size <= BLOCK_SIZE:
            raise SdoAbort(Abort.BLOCK_SIZE)
        self._upload_block = BlockUpload(data, block_size)
        return (_HEADER.pack(0xC6, index, sub) + len(data).to_bytes(4, "little"),)

    def _block_download(self, request: bytes) -> Iterable[bytes]:
        command, index, sub = _HEADER.unpack_from(request)
        block = self._download_block
        if command & 0x01:
            if block is None or not block.is_ended:
                raise SdoAbort(Abort.COMMAND)
            self._download_block = None
            self._write(block.index, block.sub, block.finish(request))
            return (b"\xa1",)
        self._read(index, sub)  # an object that is not there is refused before its data come
        size = int.from_bytes(request[4:], "little") if command & 0x02 else None
        self._download_block = BlockDownload(index, sub, size, bool(command & 0x04), _MAX_DOWNLOAD)
        return (_HEADER.pack(0xA4, index, sub) + bytes([BLOCK_SIZE]),)
