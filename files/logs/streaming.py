"""Reading of bus logs of all formats, recognised by their content, frame by frame in bounded memory.

candump (`-L`, `-ta`, `-td`, `-tz` and plain columns), Vector `.asc` and `.blf`, PEAK `.trc`, IXXAT MiniMon,
PCAP and PCAPNG, python-can's CSV, ASAM MF4; gzipped or not. What cannot be read is left out and reported line
by line; a log that was cut off is read up to there. `omnimate.files.logs.blocks` reads logs as arrays.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.candump_blocks import BlockParser, SkippedLine
from omnimate.files.logs.formats.candump_lines import ONLY_CLASSICAL, parse_line
from omnimate.files.logs.formats.foreign import foreign_format_of, read_entries
from omnimate.files.logs.frames import FD, Frame, Frames, frames_of
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from pathlib import Path

    from numpy.typing import ArrayLike

    from omnimate.files.logs.formats.foreign import ForeignFormat

HEAD_BYTES = 4096  # first bytes, from which the format is recognised
MAX_SKIPPED_LINES = 1000  # skipped lines that are stored; further ones are only counted
# Share of increasing relative times, below which they are intervals (half by chance).
MIN_INCREASING_SHARE = 0.8
_OTHER_PACKERS = {b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"\x28\xb5\x2f\xfd": "zstd", b"PK\3\4": "zip"}
REPORT_EVERY = 2000  # frames between two reports of progress


@dataclass(slots=True)
class LogReader:
    """A log that is being read, and what was left out of it.

    Attributes:
        source: Path of the file.
        frames: Number of frames so far.
        skipped: Lines that were left out so far, at most `MAX_SKIPPED_LINES`, and why.
        left_out: Number of lines that were left out so far.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
    """

    source: Path
    frames: int = field(default=0, kw_only=True)
    skipped: list[SkippedLine] = field(default_factory=list, kw_only=True)
    left_out: int = field(default=0, kw_only=True)
    truncated: bool = field(default=False, kw_only=True)

    @property
    def is_whole(self) -> bool:
        """Whether every line so far was read."""
        return not self.left_out and not self.truncated

    @contextmanager
    def reading(self) -> Iterator[tuple[BlockReader, ForeignFormat | None]]:
        """Open the file, and give its content and its format, None for candump.

        Raises:
            LogError: It cannot be read, or it held no frame in the end.
        """
        try:
            content = BlockReader(self.source)
            head = content.head(HEAD_BYTES)
            for signature, name in _OTHER_PACKERS.items():
                if head.startswith(signature):
                    raise LogError(
                        self.source, None, f"packed by {name}; expected a log, or one packed by gzip"
                    )
            yield content, foreign_format_of(head)
        except OSError as error:
            raise LogError(self.source, None, f"cannot be read: {error.strerror or error}") from error
        if not self.frames:
            empty = SkippedLine(1, "", "it ends before the first" if self.truncated else "it is empty")
            first = self.skipped[0] if self.skipped else empty
            reason = f"no CAN frame in the whole file; {first.reason}: {first.text!r}"
            raise LogError(self.source, first.line, reason)

    def skip(self, line: SkippedLine) -> None:
        """Note a line that was left out, or that the file ends early."""
        self.truncated |= line.is_end
        if line.reason:
            self.left_out += 1
            if len(self.skipped) < MAX_SKIPPED_LINES:
                self.skipped.append(line)

    def take_skipped(self, parser: BlockParser) -> None:
        """Note the lines that a parser skipped since the last call."""
        for line in parser.skipped:
            self.skip(line)
        parser.skipped.clear()

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines, and on the end of the log."""
        for line in self.skipped:
            yield f"{self.source}:{line.line}: skipped: {line.reason}: {line.text!r}"
        if self.left_out > len(self.skipped):
            yield f"{self.source}: skipped: {self.left_out - len(self.skipped)} lines more"
        if self.truncated:
            yield f"{self.source}: the log ends early; it was read up to there"


@dataclass(slots=True)
class LogStream(LogReader):
    """The frames of a log in the order of the file, CAN FD included.

    Attributes:
        size: Size of the file [bytes]; 0 before it is read.
    """

    size: int = 0
    _content: BlockReader | None = None

    @property
    def position(self) -> int:
        """Number of bytes that were read so far."""
        return 0 if self._content is None else self._content.position

    def __iter__(self) -> Iterator[Frame]:
        """Yield the frames.

        Raises:
            LogError: There is no such file, or it holds no frame.
        """
        with self.reading() as (content, form):
            self.size, self._content = self.source.stat().st_size, content
            for entry in self._candump(content) if form is None else read_entries(content, form):
                if isinstance(entry, Frame):
                    self.frames += 1
                    yield entry
                else:
                    self.skip(entry)

    def with_progress(self, progress: Callable[[int, int], None]) -> Iterator[Frame]:
        """Yield the frames; call `progress` with bytes read and total after every `REPORT_EVERY`."""
        for number, frame in enumerate(self):
            if number % REPORT_EVERY == 0:
                progress(self.position, self.size)
            yield frame

    def _candump(self, content: BlockReader) -> Iterator[Frame | SkippedLine]:
        """Yield the frames of a candump log, and note what was left out."""
        parser, last = BlockParser(fd=True), frames_of(())
        shift, adds_up = 0.0, None
        for block in content.lines():
            if block.endswith(b"\n"):
                frames = parser.parse(block)
                if adds_up is None:
                    adds_up = parser.is_relative and are_intervals(frames.time)
                for frame in frames:
                    shift += frame.time if adds_up else 0.0
                    yield frame._replace(time=shift) if adds_up else frame
                self.take_skipped(parser)
                last = frames
            elif block.strip():
                yield parse_last_line(block, parser, [last], fd=True)
        self.truncated |= content.damaged


def are_intervals(time: ArrayLike) -> bool:
    """Return whether relative times are intervals between frames, and not times since the first frame.

    The latter grow, but for frames of several interfaces that are written in another order.
    """
    grows = np.diff(np.asarray(time, np.float64)[1:]) > 0.0
    return len(grows) > 0 and float(np.mean(grows)) < MIN_INCREASING_SHARE


def parse_last_line(
    line: bytes, parser: BlockParser, before: Iterable[Frames], *, fd: bool
) -> Frame | SkippedLine:
    """Return the frame of a line without its newline, or that it was cut off, unlike those before."""
    frame = parse_line(line)
    if isinstance(frame, Frame) and frame.flags & FD and not fd:
        frame = ONLY_CLASSICAL
    if isinstance(frame, Frame) and not looks_complete(frame, before):
        frame = "its data end early"
    if isinstance(frame, Frame):
        return frame
    parser.skip(parser.lines + 1, line, f"the last line was cut off; {frame}")
    return parser.skipped.pop()._replace(is_end=True)


def looks_complete(last: Frame, pieces: Iterable[Frames]) -> bool:
    """Return whether a last frame without newline has the length of an earlier frame of its identifier."""
    kind = np.concatenate([[], *(piece.length[piece.can_id == last.can_id] for piece in pieces)])
    return len(kind) == 0 or bool(np.any(kind == last.length))
