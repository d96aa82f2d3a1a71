"""Reading of logs of any format as arrays, block by block in bounded memory.

Large logs of candump are read by several threads. `omnimate.files.logs.reading` gives a whole log at once.
"""

from __future__ import annotations

import itertools
import os
from collections import deque
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.candump_blocks import BlockParser, SkippedLine, parse_in_parallel
from omnimate.files.logs.formats.candump_lines import ONLY_CLASSICAL, STAMP_WIDTH, parse_line
from omnimate.files.logs.formats.foreign import foreign_format_of, read_entries
from omnimate.files.logs.frames import FD, Frame, Frames, frames_of
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from numpy.typing import ArrayLike

    from omnimate.files.logs.formats.foreign import ForeignFormat

HEAD_BYTES = 4096  # first bytes, from which the format is recognised
PARALLEL_SIZE = 1 << 27  # [bytes] size above which threads are faster
FRAMES_PER_BLOCK = 1 << 16  # frames per block of formats that are read frame by frame
MAX_WORKERS = 8  # threads; more are limited by the one that distributes blocks
MAX_SKIPPED_LINES = 1000  # skipped lines that are stored; further ones are only counted
MIN_INCREASING_SHARE = (
    0.8  # share of increasing relative times, below which they are intervals (half by chance)
)


@dataclass(slots=True)
class LogBlocks:
    """The classical frames of a log in the order of the file.

    Attributes:
        source: Path of the file.
        workers: Threads that read a large candump log; None for one per processor.
        frames: Number of frames so far.
        left_out: Number of lines that were left out so far.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
        is_added_up: Whether the log has the time since the frame before (`candump -td`), which is added up.
        jumps: How often the clock goes back.
        first_jump: Number of the frame after the first jump, and the times before and after it [s].
    """

    source: Path
    workers: int | None = None
    frames: int = 0
    left_out: int = 0
    truncated: bool = False
    is_added_up: bool = False
    jumps: int = 0
    first_jump: tuple[int, float, float] = (0, 0.0, 0.0)
    _parser: BlockParser = field(default_factory=BlockParser)
    _last: float | None = None
    _kept: int = 0

    @property
    def skipped(self) -> list[SkippedLine]:
        """Lines that were left out so far, at most `MAX_SKIPPED_LINES`, and why."""
        return self._parser.skipped

    @property
    def stamp_width(self) -> int:
        """Number of characters of a time in the log, with which it is printed again."""
        return self._parser.stamp_width or STAMP_WIDTH

    def __iter__(self) -> Iterator[Frames]:
        """Yield the blocks, each of at least one frame.

        Raises:
            LogError: The file cannot be read, or it holds no frame.
        """
        try:
            reader = BlockReader(self.source)
            form = foreign_format_of(reader.head(HEAD_BYTES))
            for block in self._candump(reader) if form is None else self._foreign(reader, form):
                frames = self._added_up(block)
                self._note_jumps(frames)
                self.frames += len(frames)
                self._forget_lines()
                if len(frames):
                    yield frames
            self._forget_lines()
        except OSError as error:
            raise LogError(self.source, None, f"cannot be read: {error.strerror or error}") from error
        if not self.frames:
            empty = SkippedLine(1, "", "it ends before the first" if self.truncated else "it is empty")
            first = self.skipped[0] if self.skipped else empty
            reason = f"no CAN frame in the whole file; {first.reason}: {first.text!r}"
            raise LogError(self.source, first.line, reason)

    @property
    def is_whole(self) -> bool:
        """Whether every line so far was read."""
        return not self.left_out and not self.truncated

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines, and on jumps of the clock."""
        yield from describe_skipped_lines(self.source, self.skipped, self.left_out)
        if self.is_added_up:
            yield f"{self.source}: times are since the frame before (candump -td); they were added up from 0"
        if self.truncated:
            yield f"{self.source}: the log ends early; it was read up to there"
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

    def _forget_lines(self) -> None:
        self.left_out += len(self.skipped) - self._kept
        del self.skipped[MAX_SKIPPED_LINES:]
        self._kept = len(self.skipped)

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
        entries = read_entries(reader, form, fd=False)
        channels: tuple[str, ...] = ()
        while part := list(itertools.islice(entries, FRAMES_PER_BLOCK)):
            frames = [entry for entry in part if isinstance(entry, Frame)]
            for entry in part:
                if not isinstance(entry, Frame):
                    self.truncated |= entry.is_end
                    self.skipped.extend([entry] if entry.reason else [])
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
            yield from self._last_line(last[0], before)

    def _parsed(self, blocks: Iterator[bytes]) -> Iterator[Frames]:
        if self.source.stat().st_size < PARALLEL_SIZE:
            yield from map(self._parser.parse, blocks)
            return
        workers = self.workers or min(os.cpu_count() or 1, MAX_WORKERS)
        yield from parse_in_parallel(blocks, self._parser, workers)

    def _last_line(self, line: bytes, before: deque[Frames]) -> Iterator[Frames]:
        """Yield the frame of a line without its newline, or note that it was cut off."""
        frame = parse_line(line)
        if isinstance(frame, Frame) and frame.flags & FD:
            frame = ONLY_CLASSICAL
        if isinstance(frame, str) or not looks_complete(frame, before):
            reason = frame if isinstance(frame, str) else "its data end early"
            self._parser.skip(self._parser.lines + 1, line, f"the last line was cut off; {reason}")
            self.truncated = True
        else:
            yield frames_of([frame])


def describe_skipped_lines(source: Path, kept: Iterable[SkippedLine], count: int) -> Iterator[str]:
    """Yield in words which lines were left out; `count` are all of them, of which some were kept."""
    for line in kept:
        count -= 1
        yield f"{source}:{line.line}: skipped: {line.reason}: {line.text!r}"
    if count:
        yield f"{source}: skipped: {count} lines more"


def are_intervals(time: ArrayLike) -> bool:
    """Return whether relative times are intervals between frames, and not times since the first frame.

    The latter grow, but for frames of several interfaces that are written in another order.
    """
    grows = np.diff(np.asarray(time, np.float64)[1:]) > 0.0
    return len(grows) > 0 and float(np.mean(grows)) < MIN_INCREASING_SHARE


def looks_complete(last: Frame, pieces: Iterable[Frames]) -> bool:
    """Return whether a last frame without newline has the length of an earlier frame of its identifier."""
    kind = np.concatenate([[], *(piece.length[piece.can_id == last.can_id] for piece in pieces)])
    return len(kind) == 0 or bool(np.any(kind == last.length))


def _whole_lines(reader: BlockReader, last: list[bytes]) -> Iterator[bytes]:
    """Yield the blocks of whole lines, and put what stands behind the last newline into `last`."""
    for block in reader.lines():
        if block.endswith(b"\n"):
            yield block
        else:
            last.append(block)
