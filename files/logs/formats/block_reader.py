"""Reading of plain or gzipped files in blocks, up to a damaged place."""

from __future__ import annotations

import io
import itertools
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


_GZIP = b"\x1f\x8b"
_UNPACK_SIZE = 1 << 14  # bytes unpacked at a time: an error in the packed data loses up to that many
_MAX_LINE = 1 << 20  # bytes
_AUTO_HEADER = 32 + zlib.MAX_WBITS  # zlib's wbits: expect a gzip header


@dataclass(slots=True)
class BlockReader:
    """The unpacked content of a file; of a damaged or incomplete gzip file the readable part.

    It is read `size` bytes at a time and is `damaged` where a gzip file turns out to end early or to be
    corrupt; `position` bytes of the file were read, packed as they are, and `passed` were handed on,
    unpacked.
    """

    path: Path
    size: int = 1 << 21
    damaged: bool = False
    position: int = 0
    passed: int = 0
    _blocks: Iterator[bytes] | None = field(default=None, init=False)
    _ahead: list[bytes] = field(default_factory=list, init=False)

    def __iter__(self) -> Iterator[bytes]:
        blocks = self._blocks or self._read()
        self._blocks = None
        ahead, self._ahead = self._ahead, []
        for block in itertools.chain(ahead, blocks):
            self.passed += len(block)
            yield block

    def head(self, count: int) -> bytes:
        """Return the first bytes of the content without consuming them."""
        self._blocks = self._blocks or self._read()
        while sum(map(len, self._ahead)) < count and (block := next(self._blocks, None)) is not None:
            self._ahead.append(block)
        return b"".join(self._ahead)[:count]

    def _read(self) -> Iterator[bytes]:
        with self.path.open("rb") as file:
            packed = file.peek(len(_GZIP)).startswith(_GZIP)  # a pipe cannot be read twice
            size = self.size // 8 if packed else self.size
            blocks = self._counted(iter(lambda: file.read(size), b""))
            yield from self._unpack(blocks) if packed else blocks

    def file(self) -> io.BufferedReader:
        """Return the content as a file that is read from its beginning to its end."""
        return io.BufferedReader(_Content(iter(self)))

    def lines(self) -> Iterator[bytes]:
        """Yield blocks of whole lines; the last one may lack its newline, and may be empty."""
        rest = bytearray()
        for block in self:
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


class _Content(io.RawIOBase):
    """Blocks of bytes as a file."""

    def __init__(self, blocks: Iterator[bytes]) -> None:
        super().__init__()
        self._blocks = blocks
        self._rest = memoryview(b"")

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:  # noqa: ANN401 -- any writable buffer; it has a name from 3.12 on
        target = memoryview(buffer).cast("B")
        while not self._rest:
            block = next(self._blocks, None)
            if block is None:
                return 0
            self._rest = memoryview(block)
        count = min(len(target), len(self._rest))
        target[:count] = self._rest[:count]
        self._rest = self._rest[count:]
        return count
