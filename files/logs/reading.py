"""Reading of bus logs of all supported formats, recognised by their content.

candump (`-L`, `-ta`, `-td`, `-tz` and plain columns), Vector `.asc` and `.blf`, PEAK `.trc`, IXXAT MiniMon,
PCAP and PCAPNG, python-can's CSV, ASAM MF4; gzipped or not. What cannot be read is left out and reported line
by line; a log that was cut off is read up to there.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from omnimate.files.logs.blocks import LogBlocks
from omnimate.files.logs.frames import Frames, concatenate
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.logs.formats.candump_blocks import SkippedLine


@dataclass(frozen=True, slots=True)
class LogReadResult:
    """The readable part of a log.

    Attributes:
        frames: The frames in the order of the file.
        blocks: The blocks in which it was read, and what was left out of them.
    """

    frames: Frames
    blocks: LogBlocks

    @property
    def source(self) -> Path:
        """Path of the file."""
        return self.blocks.source

    @property
    def skipped(self) -> tuple[SkippedLine, ...]:
        """Lines that were left out, at most `MOST_KEPT`, and why."""
        return tuple(self.blocks.skipped)

    @property
    def truncated(self) -> bool:
        """Whether the file ends in the middle of a line or of its compressed data."""
        return self.blocks.truncated

    @property
    def stamp_width(self) -> int:
        """Number of characters of a time in the log, with which it is printed again."""
        return self.blocks.stamp_width

    @property
    def is_whole(self) -> bool:
        """Whether every line was read to the end of the file."""
        return self.blocks.is_whole

    def problems(self) -> Iterator[str]:
        """Yield sentences on skipped lines, and on jumps of the clock."""
        return self.blocks.problems()


def read_log(path: Path | str, *, strict: bool = False) -> LogReadResult:
    """Return the frames of a log file of any known format.

    Args:
        path: Path of the file; its content decides on the format, not its suffix.
        strict: Whether a log is refused that cannot be read completely.

    Raises:
        LogError: There is no such file, it holds no frame, or `strict` is set and a line was left out.
    """
    blocks = LogBlocks(Path(path))
    result = LogReadResult(concatenate(list(blocks)), blocks)
    if strict and not result.is_whole:
        line = result.skipped[0].line if result.skipped else None
        raise LogError(blocks.source, line, next(result.problems()).removeprefix(f"{blocks.source}:"))
    return result
