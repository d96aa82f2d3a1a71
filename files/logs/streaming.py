"""Reading of logs of any format, frame by frame in bounded memory.

`omnimate.files.logs.reading` gives a whole log as arrays, of classical CAN only. Here CAN FD frames come too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.files.logs.blocks import (
    HEAD_BYTES,
    MAX_SKIPPED_LINES,
    are_intervals,
    describe_skipped_lines,
    looks_complete,
)
from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.logs.formats.candump_blocks import BlockParser, SkippedLine
from omnimate.files.logs.formats.candump_lines import parse_line
from omnimate.files.logs.formats.foreign import foreign_format_of, read_entries
from omnimate.files.logs.frames import FD, Frame, frames_of
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

REPORT_EVERY = 2000  # frames between two reports of progress


@dataclass(slots=True)
class LogStream:
    """The frames of a log in the order of the file, CAN FD included.

    Attributes:
        source: Path of the file.
        frames: Number of frames so far.
        skipped: Lines that were left out so far, at most `MAX_SKIPPED_LINES`, and why.
        left_out: Number of lines that were left out so far.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
        size: Size of the file [bytes]; 0 before it is read.
        position: Number of bytes that were read so far.
    """

    source: Path
    frames: int = 0
    skipped: list[SkippedLine] = field(default_factory=list)
    left_out: int = 0
    truncated: bool = False
    size: int = 0
    _content: BlockReader | None = None

    @property
    def position(self) -> int:
        """Number of bytes that were read so far."""
        return 0 if self._content is None else self._content.position

    @property
    def is_whole(self) -> bool:
        """Whether every line was read to the end of the file."""
        return not self.left_out and not self.truncated

    def __iter__(self) -> Iterator[Frame]:
        """Yield the frames.

        Raises:
            LogError: There is no such file, or it holds no frame.
        """
        try:
            for entry in self._entries():
                if isinstance(entry, Frame):
                    self.frames += 1
                    yield entry
                else:
                    self._skip(entry)
        except OSError as error:
            raise LogError(self.source, None, f"cannot be read: {error.strerror or error}") from error
        if not self.frames:
            reason = f"{self.skipped[0].reason}: {self.skipped[0].text!r}" if self.skipped else "it is empty"
            raise LogError(self.source, None, f"no CAN frame in the whole file; {reason}")

    def with_progress(self, progress: Callable[[int, int], None]) -> Iterator[Frame]:
        """Yield the frames; call `progress` with bytes read and total after every `REPORT_EVERY`."""
        for number, frame in enumerate(self):
            if number % REPORT_EVERY == 0:
                progress(self.position, self.size)
            yield frame

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines."""
        yield from describe_skipped_lines(self.source, self.skipped, self.left_out)
        if self.truncated:
            yield f"{self.source}: the log ends early; it was read up to there"

    def _skip(self, line: SkippedLine) -> None:
        self.truncated |= line.is_end
        if line.reason:
            self.left_out += 1
            if len(self.skipped) < MAX_SKIPPED_LINES:
                self.skipped.append(line)

    def _entries(self) -> Iterator[Frame | SkippedLine]:
        self.size = self.source.stat().st_size
        self._content = BlockReader(self.source)
        form = foreign_format_of(self._content.head(HEAD_BYTES))
        return _read_candump(self._content) if form is None else read_entries(self._content, form)


def _read_candump(content: BlockReader) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of a candump log, and what was left out."""
    parser = BlockParser()
    shift, adds_up = 0.0, None
    last: list[Frame] = []
    for block in content.lines():
        if not block.endswith(b"\n"):
            yield from _last_line(block, parser, last)
            continue
        frames = list(parser.each(block))
        if adds_up is None:
            adds_up = parser.has_relative_times(block) and are_intervals([frame.time for frame in frames])
        for frame in frames:
            shift += frame.time if adds_up else 0.0
            yield frame._replace(time=shift) if adds_up else frame
        yield from parser.skipped
        parser.skipped.clear()
        last = frames
    if content.damaged:
        yield SkippedLine(0, "", "", is_end=True)


def _last_line(line: bytes, parser: BlockParser, before: list[Frame]) -> Iterator[Frame | SkippedLine]:
    """Yield the frame of a line without its newline, or say that it was cut off."""
    if not line.strip():
        return
    frame = parse_line(line)
    classical = [frames_of(row for row in before if not row.flags & FD)]
    if isinstance(frame, Frame) and looks_complete(frame, classical):
        yield frame
    else:
        reason = frame if isinstance(frame, str) else "its data end early"
        parser.skip(parser.lines + 1, line, f"the last line was cut off; {reason}")
        yield parser.skipped.pop()._replace(is_end=True)
