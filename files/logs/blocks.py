"""Reading of logs of any format as arrays, whole or block by block in bounded memory.

Large logs of candump are read by several threads.
"""

from __future__ import annotations

import itertools
import os
from collections import deque
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.formats.candump_blocks import BlockParser, parse_in_parallel
from omnimate.files.logs.formats.candump_lines import STAMP_WIDTH
from omnimate.files.logs.formats.foreign import read_entries
from omnimate.files.logs.frames import Frame, Frames, concatenate, frames_of
from omnimate.files.logs.streaming import LogReader, are_intervals, parse_last_line

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.logs.formats.block_reader import BlockReader
    from omnimate.files.logs.formats.foreign import ForeignFormat

PARALLEL_SIZE = 1 << 27  # [bytes] size above which threads are faster
FRAMES_PER_BLOCK = 1 << 16  # frames per block of formats that are read frame by frame
MAX_WORKERS = 8  # threads; more are limited by the one that distributes blocks


class LogReadResult(NamedTuple):
    """The readable part of a log.

    The frames are in the order of the file.
    """

    frames: Frames
    blocks: LogBlocks


def read_log(path: Path | str) -> LogReadResult:
    """Return the frames of a log of any known format, which its content decides, not its suffix.

    Raises:
        LogError: There is no such file, or it holds no frame.
    """
    blocks = LogBlocks(Path(path))
    return LogReadResult(concatenate(list(blocks)), blocks)


@dataclass(slots=True)
class LogBlocks(LogReader):
    """The frames of a log in the order of the file.

    Attributes:
        fd: Whether CAN FD frames are read, and not skipped.
        workers: Threads that read a large candump log; None for one per processor.
        is_added_up: Whether the log has the time since the frame before (`candump -td`), which is added up.
        jumps: How often the clock goes back.
        first_jump: Number of the frame after the first jump, and the times before and after it [s].
    """

    fd: bool = False
    workers: int | None = None
    is_added_up: bool = False
    jumps: int = 0
    first_jump: tuple[int, float, float] = (0, 0.0, 0.0)
    _parser: BlockParser = field(init=False)
    _last: float | None = None

    def __post_init__(self) -> None:
        self._parser = BlockParser(self.fd)

    @property
    def stamp_width(self) -> int:
        """Number of characters of a time in the log, with which it is printed again."""
        return self._parser.stamp_width or STAMP_WIDTH

    def __iter__(self) -> Iterator[Frames]:
        """Yield the blocks, each of at least one frame.

        Raises:
            LogError: The file cannot be read, or it holds no frame.
        """
        with self.reading() as (reader, form):
            for block in self._candump(reader) if form is None else self._foreign(reader, form):
                frames = self._added_up(block)
                self._note_jumps(frames)
                self.frames += len(frames)
                self.take_skipped(self._parser)
                if len(frames):
                    yield frames
            self.take_skipped(self._parser)

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines, on the end of the log, on times, and on jumps of the clock."""
        yield from LogReader.problems(self)
        if self.is_added_up:
            yield f"{self.source}: times are since the frame before (candump -td); they were added up from 0"
        if self.jumps:
            frame, before, after = self.first_jump
            where = f"first at frame {frame} from {before:.6f} s to {after:.6f} s"
            yield f"{self.source}: the clock goes back {self.jumps} times, {where}"

    def _added_up(self, frames: Frames) -> Frames:
        """Return a block with absolute times; the first one says whether its times are to be added up."""
        if not self.frames and len(frames):
            self.is_added_up = self._parser.is_relative and are_intervals(frames.time)
        if not self.is_added_up:
            return frames
        start = self._last or 0.0
        return replace(frames, time=np.cumsum(np.concatenate(([start], frames.time)))[1:])

    def _note_jumps(self, frames: Frames) -> None:
        if not len(frames):
            return
        before = float(frames.time[0]) if self._last is None else self._last
        times = np.concatenate(([before], frames.time))
        jumps = np.flatnonzero(np.diff(times) < 0)
        if len(jumps) and not self.jumps:
            at = int(jumps[0])
            self.first_jump = (self.frames + at + 1, float(times[at]), float(times[at + 1]))
        self.jumps += len(jumps)
        self._last = float(times[-1])

    def _foreign(self, reader: BlockReader, form: ForeignFormat) -> Iterator[Frames]:
        entries = read_entries(reader, form, fd=self.fd)
        channels: tuple[str, ...] = ()
        while part := list(itertools.islice(entries, FRAMES_PER_BLOCK)):
            frames = [entry for entry in part if isinstance(entry, Frame)]
            for entry in part:
                if not isinstance(entry, Frame):
                    self.skip(entry)
            if frames:
                block = frames_of(frames, channels)
                channels = block.channels
                yield block

    def _candump(self, reader: BlockReader) -> Iterator[Frames]:
        before = deque[Frames](maxlen=2)
        last: list[bytes] = []
        for frames in self._parsed(_whole_lines(reader, last)):
            before.append(frames)
            yield frames
        self.truncated = reader.damaged
        if last and last[0].strip():
            entry = parse_last_line(last[0], self._parser, before, fd=self.fd)
            if isinstance(entry, Frame):
                yield frames_of([entry])
            else:
                self.skip(entry)

    def _parsed(self, blocks: Iterator[bytes]) -> Iterator[Frames]:
        if self.source.stat().st_size < PARALLEL_SIZE:
            yield from map(self._parser.parse, blocks)
            return
        workers = self.workers or min(os.cpu_count() or 1, MAX_WORKERS)
        yield from parse_in_parallel(blocks, self._parser, workers)


def _whole_lines(reader: BlockReader, last: list[bytes]) -> Iterator[bytes]:
    """Yield the blocks of whole lines, and put what stands behind the last newline into `last`."""
    for block in reader.lines():
        if block.endswith(b"\n"):
            yield block
        else:
            last.append(block)
