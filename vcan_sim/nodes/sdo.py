"""The SDO server of a device: expedited and segmented transfers, one answer per request (CiA 301 7.2.4)."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort

if TYPE_CHECKING:
    from collections.abc import Callable

_HEADER = struct.Struct("<BHB")
_ABORT = struct.Struct("<BHBL")
_LONGEST_DOWNLOAD = 64  # [byte]; no object of ours is longer


@dataclass(slots=True)
class _Transfer:
    """A segmented transfer under way."""

    index: int
    sub: int
    upload: bool
    buffer: bytearray = field(default_factory=bytearray)
    toggle: int = 0


class SdoServer:
    """Answers the requests of one client."""

    def __init__(self, read: Callable[[int, int], bytes], write: Callable[[int, int, bytes], None]) -> None:
        self._read = read
        self._write = write
        self._transfer: _Transfer | None = None
        self._steps = {
            0: self._download_segment,
            1: self._download,
            2: self._upload,
            3: self._upload_segment,
        }

    def reset(self) -> None:
        """Forget a transfer under way."""
        self._transfer = None

    def answer(self, request: bytes) -> bytes | None:
        """Return the answer to a request, None where there is none (an abort, or not 8 bytes)."""
        if len(request) != 8 or request[0] >> 5 == 4:
            self._transfer = None
            return None
        specifier = request[0] >> 5
        _, index, sub = _HEADER.unpack_from(request)
        if specifier in {0, 3} and self._transfer is not None:
            index, sub = self._transfer.index, self._transfer.sub
        try:
            step = self._steps.get(specifier, self._refuse)
            return step(request).ljust(8, b"\0")
        except SdoAbort as abort:
            self._transfer = None
            return _ABORT.pack(0x80, index, sub, abort.code)

    @staticmethod
    def _refuse(_request: bytes) -> bytes:
        """Refuse block transfers; a client falls back to segments."""
        raise SdoAbort(Abort.COMMAND)

    def _upload(self, request: bytes) -> bytes:
        _, index, sub = _HEADER.unpack_from(request)
        data = self._read(index, sub)
        if not data:
            raise SdoAbort(Abort.NO_DATA)
        if len(data) <= 4:
            self._transfer = None
            return _HEADER.pack(0x43 | (4 - len(data)) << 2, index, sub) + data
        self._transfer = _Transfer(index, sub, upload=True, buffer=bytearray(data))
        return _HEADER.pack(0x41, index, sub) + len(data).to_bytes(4, "little")

    def _upload_segment(self, request: bytes) -> bytes:
        transfer = self._under_way(request, upload=True)
        part = bytes(transfer.buffer[:7])
        del transfer.buffer[:7]
        last = not transfer.buffer
        head = (request[0] & 0x10) | (7 - len(part)) << 1 | last
        self._transfer = None if last else transfer
        return bytes([head]) + part

    def _download(self, request: bytes) -> bytes:
        command, index, sub = _HEADER.unpack_from(request)
        self._transfer = None
        if command & 0x02:
            size = 4 - (command >> 2 & 0x03) if command & 0x01 else 4
            self._write(index, sub, request[4 : 4 + size])
        else:
            self._read(index, sub)  # an object that is not there is refused before its data come
            self._transfer = _Transfer(index, sub, upload=False)
        return _HEADER.pack(0x60, index, sub)

    def _download_segment(self, request: bytes) -> bytes:
        transfer = self._under_way(request, upload=False)
        transfer.buffer += request[1 : 8 - (request[0] >> 1 & 0x07)]
        if len(transfer.buffer) > _LONGEST_DOWNLOAD:
            raise SdoAbort(Abort.LENGTH)
        if request[0] & 0x01:
            self._transfer = None
            self._write(transfer.index, transfer.sub, bytes(transfer.buffer))
        return bytes([0x20 | (request[0] & 0x10)])

    def _under_way(self, request: bytes, *, upload: bool) -> _Transfer:
        """Return the transfer that a segment belongs to, its toggle bit checked."""
        transfer = self._transfer
        if transfer is None or transfer.upload is not upload:
            raise SdoAbort(Abort.COMMAND)
        if request[0] & 0x10 != transfer.toggle:
            raise SdoAbort(Abort.TOGGLE)
        transfer.toggle ^= 0x10
        return transfer
