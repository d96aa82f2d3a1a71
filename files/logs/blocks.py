"""Reading of bus logs of all formats, recognised by their content: whole, by blocks of arrays, or by frames.

candump (`-L`, `-ta`, `-td`, `-tz` and plain columns), Vector `.asc` and `.blf`, PEAK `.trc`, IXXAT MiniMon,
PCAP and PCAPNG, python-can's CSV, ASAM MF4; gzipped or not. What cannot be read is left out and reported line
by line; a log that was cut off is read up to there. Memory is bounded; several threads read large logs of
candump.
"""

from __future__ import annotations

import itertools
import os
from codecs import BOM_UTF8
from collections import deque
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.candump_blocks import (
    BlockParser,
    SkippedLine,
    parse_in_parallel,
    skipped_line,
)
from omnimate.files.logs.formats.candump_lines import STAMP_WIDTH, is_comment, parse_line, refuse_fd
from omnimate.files.logs.formats.foreign import foreign_format_of, read_entries
from omnimate.files.logs.frames import Frame, Frames, concatenate, frames_of
from omnimate.vehicle.errors import IS_UTF_16, UTF_16_MARKS, LogError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from numpy.typing import ArrayLike

    from omnimate.files.logs.formats.foreign import ForeignFormat

PARALLEL_SIZE = 1 << 27  # [bytes] size above which threads are faster
FRAMES_PER_BLOCK = 1 << 16  # frames per block of formats that are read frame by frame
MAX_WORKERS = 8  # threads; more are limited by the one that distributes blocks
HEAD_BYTES = 4096  # first bytes, from which the format is recognised
MAX_SKIPPED_LINES = 1000  # skipped lines that are stored; further ones are only counted
# Share of increasing relative times, below which they are intervals (half by chance).
MIN_INCREASING_SHARE = 0.8
_OTHER_PACKERS = {b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"\x28\xb5\x2f\xfd": "zstd", b"PK\3\4": "zip"}
REPORT_EVERY = 2000  # frames between two reports of progress


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
class LogReader:
    """A log that is being read, and what was left out of it.

    Attributes:
        source: Path of the file.
        fd: Whether CAN FD frames are read, and not skipped.
        workers: Threads that read a large candump log; None for one per processor.
        frames: Number of frames so far.
        skipped: Lines that were left out so far, at most `MAX_SKIPPED_LINES`, and why.
        left_out: Number of lines that were left out so far.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
        is_added_up: Whether the log has the time since the frame before (`candump -td`), which is added up.
    """

    source: Path
    fd: bool = field(default=False, kw_only=True)
    workers: int | None = field(default=None, kw_only=True)
    frames: int = field(default=0, init=False)
    skipped: list[SkippedLine] = field(default_factory=list, init=False)
    left_out: int = field(default=0, init=False)
    truncated: bool = field(default=False, init=False)
    is_added_up: bool = field(default=False, init=False)
    _parser: BlockParser = field(init=False)

    def __post_init__(self) -> None:
        self._parser = BlockParser(self.fd)

    @property
    def is_whole(self) -> bool:
        """Whether every line so far was read."""
        return not self.left_out and not self.truncated

    @contextmanager
    def _reading(self) -> Iterator[tuple[BlockReader, ForeignFormat | None]]:
        """Open the file, and give its content and its format, None for candump.

        Raises:
            LogError: It cannot be read, or it held no frame in the end.
        """
        try:
            content = BlockReader(self.source)
            if content.head(len(BOM_UTF8)) == BOM_UTF8:  # as editors on Windows write it
                content.file.read(len(BOM_UTF8))
            head = content.head(HEAD_BYTES)
            for signature, name in _OTHER_PACKERS.items():
                if head.startswith(signature):
                    raise LogError(
                        self.source, None, f"packed by {name}; expected a log, or one packed by gzip"
                    )
            if head.startswith(UTF_16_MARKS):
                raise LogError(self.source, None, IS_UTF_16)
            yield content, foreign_format_of(head)
        except OSError as error:
            raise LogError(self.source, None, f"cannot be read: {error.strerror or error}") from error
        if not self.frames:
            empty = SkippedLine(1, "", "it ends before the first" if self.truncated else "it is empty")
            first = self.skipped[0] if self.skipped else empty
            reason = f"no CAN frame in the whole file; {first.reason}: {first.text!r}"
            raise LogError(self.source, first.line, reason)

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines, and on the end of the log."""
        for line in self.skipped:
            yield f"{self.source}:{line.line}: skipped: {line.reason}: {line.text!r}"
        if self.left_out > len(self.skipped):
            yield f"{self.source}: skipped: {self.left_out - len(self.skipped)} lines more"
        if self.truncated:
            yield f"{self.source}: the log ends early; it was read up to there"

    def _skip(self, line: SkippedLine) -> None:
        """Note a line that was left out, or that the file ends early."""
        self.truncated |= line.is_end
        if line.reason:
            self.left_out += 1
            if len(self.skipped) < MAX_SKIPPED_LINES:
                self.skipped.append(line)

    def _candump(self, reader: BlockReader) -> Iterator[Frames]:
        """Yield the blocks of a candump log with absolute times; the first shows whether to add them up."""
        last_time, is_first = 0.0, True
        for frames in self._candump_blocks(reader):
            if is_first and len(frames):
                self.is_added_up = self._parser.is_relative and are_intervals(frames.time)
                is_first = False
            if self.is_added_up:
                times = np.cumsum(np.concatenate(([last_time], frames.time)))
                last_time = float(times[-1])
                yield replace(frames, time=times[1:])
            else:
                yield frames

    def _candump_blocks(self, reader: BlockReader) -> Iterator[Frames]:
        before = deque[Frames](maxlen=2)
        last: list[bytes] = []
        for frames in self._parsed(_whole_lines(reader, last)):
            before.append(frames)
            for line in self._parser.skipped:
                self._skip(line)
            self._parser.skipped.clear()
            yield frames
        self.truncated |= reader.damaged
        if last and not is_comment(last[0]):
            entry = self._last_line(last[0], before)
            if isinstance(entry, Frame):
                yield frames_of([entry])
            else:
                self._skip(entry)

    def _parsed(self, blocks: Iterator[bytes]) -> Iterator[Frames]:
        if self.source.stat().st_size < PARALLEL_SIZE:
            yield from map(self._parser.parse, blocks)
            return
        workers = self.workers or min(os.cpu_count() or 1, MAX_WORKERS)
        yield from parse_in_parallel(blocks, self._parser, workers)

    def _last_line(self, line: bytes, before: Iterable[Frames]) -> Frame | SkippedLine:
        """Return the frame of a line without its newline, or that it was cut off, unlike those before."""
        frame = refuse_fd(parse_line(line), fd=self.fd)
        if isinstance(frame, Frame) and not _looks_complete(frame, before):
            frame = "its data end early"
        if isinstance(frame, Frame):
            return frame
        return skipped_line(self._parser.lines + 1, line, f"the last line was cut off; {frame}", is_end=True)


@dataclass(slots=True)
class LogBlocks(LogReader):
    """The frames of a log in the order of the file, as arrays.

    Attributes:
        jumps: How often the clock goes back.
        first_jump: Number of the frame after the first jump, and the times before and after it [s].
    """

    jumps: int = field(default=0, init=False)
    first_jump: tuple[int, float, float] = field(default=(0, 0.0, 0.0), init=False)
    _last: float | None = field(default=None, init=False)

    @property
    def stamp_width(self) -> int:
        """Number of characters of a time in the log, with which it is printed again."""
        return self._parser.stamp_width or STAMP_WIDTH

    def __iter__(self) -> Iterator[Frames]:
        """Yield the blocks, each of at least one frame.

        Raises:
            LogError: The file cannot be read, or it holds no frame.
        """
        with self._reading() as (reader, form):
            for frames in self._candump(reader) if form is None else self._foreign(reader, form):
                if len(frames):
                    self._note_jumps(frames)
                    self.frames += len(frames)
                    yield frames

    def problems(self) -> Iterator[str]:
        """Yield sentences on times, on jumps of the clock, on skipped lines, and on the end of the log."""
        if self.is_added_up:
            yield f"{self.source}: times are since the frame before (candump -td); they were added up from 0"
        if self.jumps:
            frame, before, after = self.first_jump
            where = f"first at frame {frame} from {before:.6f} s to {after:.6f} s"
            yield f"{self.source}: the clock goes back {self.jumps} times, {where}"
        yield from LogReader.problems(self)  # these may be many, of which a caller shows the first

    def _note_jumps(self, frames: Frames) -> None:
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
                    self._skip(entry)
            if frames:
                block = frames_of(frames, channels)
                channels = block.channels
                yield block


@dataclass(slots=True)
class LogStream(LogReader):
    """The frames of a log in the order of the file one by one, CAN FD included.

    Attributes:
        size: Size of the file [bytes]; 0 before it is read.
    """

    fd: bool = field(default=True, kw_only=True)
    size: int = field(default=0, init=False)
    _content: BlockReader | None = field(default=None, init=False)

    @property
    def position(self) -> int:
        """Number of bytes that were read so far."""
        return 0 if self._content is None else self._content.position

    def __iter__(self) -> Iterator[Frame]:
        """Yield the frames.

        Raises:
            LogError: There is no such file, or it holds no frame.
        """
        with self._reading() as (content, form):
            self.size, self._content = self.source.stat().st_size, content
            candump = itertools.chain.from_iterable(self._candump(content))
            for entry in candump if form is None else read_entries(content, form, fd=self.fd):
                if isinstance(entry, Frame):
                    self.frames += 1
                    yield entry
                else:
                    self._skip(entry)

    def with_progress(self, progress: Callable[[int, int], None]) -> Iterator[Frame]:
        """Yield the frames; call `progress` with bytes read and total after every `REPORT_EVERY`."""
        for number, frame in enumerate(self):
            if number % REPORT_EVERY == 0:
                progress(self.position, self.size)
            yield frame


def _whole_lines(reader: BlockReader, last: list[bytes]) -> Iterator[bytes]:
    """Yield the blocks of whole lines, and put what stands behind the last newline into `last`."""
    for block in reader.lines():
        if block.endswith(b"\n"):
            yield block
        else:
            last.append(block)


def are_intervals(time: ArrayLike) -> bool:
    """Return whether relative times are intervals between frames, and not times since the first frame.

    The latter grow, but for frames of several interfaces that are written in another order.
    """
    grows = np.diff(np.asarray(time, np.float64)[1:]) > 0.0
    return len(grows) > 0 and float(np.mean(grows)) < MIN_INCREASING_SHARE


def _looks_complete(last: Frame, pieces: Iterable[Frames]) -> bool:
    """Return whether a last frame without newline has the length of an earlier frame of its identifier."""
    kind = np.concatenate([[], *(piece.length[piece.can_id == last.can_id] for piece in pieces)])
    return len(kind) == 0 or bool(np.any(kind == last.length))
