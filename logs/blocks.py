"""Logs of any size and format as arrays, block by block; what is in memory does not grow with the log.

Large logs of candump are read by several threads. `omnimate.logs.reading` gives a whole log at once.
"""

from __future__ import annotations

import itertools
import os
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.logs.formats.block_reader import BlockReader
from omnimate.logs.formats.candump_blocks import BlockParser, SkippedLine
from omnimate.logs.formats.candump_lines import ONLY_CLASSICAL, parse_line
from omnimate.logs.formats.foreign import each_entry, foreign_format_of
from omnimate.logs.frames import FD, Frame, Frames, frames_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from omnimate.logs.formats.foreign import ForeignFormat

HEAD = 4096  # bytes in which a format shows itself
LARGE = 1 << 27  # bytes of a file from which on loading the machine code pays
AT_ONCE = 1 << 16  # frames of a format that is read frame by frame in a block
MOST_WORKERS = 8  # one thread hands the blocks out and takes them back in order


@dataclass(slots=True)
class LogBlocks:
    """The classical frames of a log in the order of the file.

    Attributes:
        source: Path of the file.
        workers: Threads that read a large candump log; None for one per processor.
        parser: What has been learned of a candump log: interfaces, width of times, skipped lines.
        skipped: Lines that were left out so far, and why.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
    """

    source: Path
    workers: int | None = None
    parser: BlockParser = field(default_factory=BlockParser)
    skipped: list[SkippedLine] = field(default_factory=list)
    truncated: bool = False

    def __iter__(self) -> Iterator[Frames]:
        """Yield the blocks; times of `candump -td` are as they stand there.

        Raises:
            OSError: The file cannot be read.
        """
        head = b"".join(itertools.islice(BlockReader(self.source, HEAD), 1))
        form = foreign_format_of(head)
        yield from self._candump() if form is None else self._foreign(form)

    def _foreign(self, form: ForeignFormat) -> Iterator[Frames]:
        entries = each_entry(BlockReader(self.source), form, fd=False)
        while part := list(itertools.islice(entries, AT_ONCE)):
            frames = [entry for entry in part if isinstance(entry, Frame)]
            for entry in part:
                if not isinstance(entry, Frame):
                    self.truncated |= entry.is_end
                    self.skipped += [entry] if entry.reason else []
            if frames:
                yield frames_of(frames)

    def _candump(self) -> Iterator[Frames]:
        reader, before = BlockReader(self.source), deque[Frames](maxlen=2)
        last: list[bytes] = []
        for frames in self._parsed(_whole_lines(reader, last)):
            before.append(frames)
            yield frames
        self.truncated = reader.damaged
        self.skipped = self.parser.skipped
        if last and last[0].strip():
            yield from self._last_line(last[0], before)

    def _parsed(self, blocks: Iterator[bytes]) -> Iterator[Frames]:
        if self.source.stat().st_size < LARGE:
            yield from map(self.parser.parse, blocks)
            return
        from omnimate.logs.formats.candump_kernel import parse_in_parallel  # noqa: PLC0415  # it loads numba

        workers = self.workers or min(os.cpu_count() or 1, MOST_WORKERS)
        yield from parse_in_parallel(blocks, self.parser, workers)

    def _last_line(self, line: bytes, before: deque[Frames]) -> Iterator[Frames]:
        """Yield the frame of a line without its newline, or note that it was cut off."""
        frame = parse_line(line)
        if isinstance(frame, Frame) and frame.flags & FD:
            frame = ONLY_CLASSICAL
        if isinstance(frame, str) or not looks_complete(frame, before):
            reason = frame if isinstance(frame, str) else "its data end early"
            self.parser.skip(self.parser.lines + 1, line, f"the last line was cut off; {reason}")
            self.truncated = True
        else:
            yield frames_of([frame])


def looks_complete(last: Frame, pieces: Iterable[Frames]) -> bool:
    """Say whether the last frame, whose line has no newline, is as long as one of its kind before it."""
    kind = np.concatenate([[], *(piece.length[piece.can_id == last.can_id] for piece in pieces)])
    return len(kind) == 0 or bool(np.any(kind == last.length))


def _whole_lines(reader: BlockReader, last: list[bytes]) -> Iterator[bytes]:
    """Yield the blocks of whole lines, and put what stands behind the last newline into `last`."""
    for block in reader.lines():
        if block.endswith(b"\n"):
            yield block
        else:
            last.append(block)
