"""Reading of plain or gzipped files in blocks, up to a damaged place."""

from __future__ import annotations

import io
import zlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


_GZIP = b"\x1f\x8b"
_UNPACK_SIZE = 1 << 14  # bytes unpacked at a time: an error in the packed data loses up to that many
_MAX_LINE = 1 << 20  # bytes
_AUTO_HEADER = 32 + zlib.MAX_WBITS  # zlib's wbits: expect a gzip header


class BlockReader(io.RawIOBase):
    """The unpacked content of a file; of a damaged or incomplete gzip file the readable part.

    It is read through `file`, once, `size` bytes at a time, and is `damaged` where a gzip file turns out to
    end early or to be corrupt; `position` bytes of the file were read, packed as they are, and `passed` were
    handed on, unpacked.
    """

    def __init__(self, path: Path, size: int = 1 << 21) -> None:
        """Prepare to read; the file is opened at the first read."""
        super().__init__()
        self.path, self.size = path, size
        self.damaged = False
        self.position = self.passed = 0
        self._pieces = self._read()
        self._rest = memoryview(b"")
        self.file = io.BufferedReader(self, size)

    def head(self, count: int) -> bytes:
        """Return the first bytes of the content, at most `size`, without consuming them."""
        return self.file.peek(count)[:count]

    def lines(self) -> Iterator[bytes]:
        """Yield blocks of whole lines; the last one may lack its newline, and may be empty."""
        rest = bytearray()
        while block := self.file.read(self.size):
            rest += block
            end = rest.rfind(b"\n") + 1 if len(rest) >= self.size else 0
            if end:
                yield bytes(rest[:end])
                del rest[:end]
            elif len(rest) > self.size + _MAX_LINE:
                del rest[_MAX_LINE:]  # no log has lines of this length: what is cut off is garbage too
        end = rest.rfind(b"\n") + 1
        if end:
            yield bytes(rest[:end])
        yield bytes(rest[end:])

    def readable(self) -> bool:
        """Return that it can be read."""
        return True

    def readinto(self, buffer: Any) -> int:  # noqa: ANN401 -- any writable buffer; it has a name from 3.12 on
        """Fill a buffer with what comes next, and return how many bytes that are."""
        target, filled = memoryview(buffer).cast("B"), 0
        while filled < len(target):
            if not self._rest:
                piece = next(self._pieces, None)
                if piece is None:
                    break
                self._rest = memoryview(piece)
            count = min(len(target) - filled, len(self._rest))
            target[filled : filled + count] = self._rest[:count]
            self._rest = self._rest[count:]
            filled += count
        self.passed += filled
        return filled

    def _read(self) -> Iterator[bytes]:
        with self.path.open("rb") as file:
            packed = file.peek(len(_GZIP)).startswith(_GZIP)  # a pipe cannot be read twice
            size = self.size // 8 if packed else self.size
            blocks = self._counted(iter(lambda: file.read(size), b""))
            yield from self._unpack(blocks) if packed else blocks

    def _counted(self, blocks: Iterator[bytes]) -> Iterator[bytes]:
        for block in blocks:
            self.position += len(block)
            yield block

    def _unpack(self, blocks: Iterator[bytes]) -> Iterator[bytes]:
        unpacker = zlib.decompressobj(_AUTO_HEADER)
        try:
            for block in blocks:
                packed = block
                while packed:
                    if unpacker.eof:  # several gzip files in one, as `cat` makes them
                        unpacker = zlib.decompressobj(_AUTO_HEADER)
                    yield unpacker.decompress(packed, _UNPACK_SIZE)
                    packed = unpacker.unused_data if unpacker.eof else unpacker.unconsumed_tail
        except zlib.error:
            self.damaged = True
        self.damaged = self.damaged or not unpacker.eof
