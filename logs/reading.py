"""Bus logs of every format that people have, recognised by their content.

candump (`-L`, `-ta`, `-td`, `-tz` and plain columns), Vector `.asc` and `.blf`, PEAK `.trc`, IXXAT MiniMon,
PCAP and PCAPNG, python-can's CSV, ASAM MF4; gzipped or not. What cannot be read is left out and reported line
by line; a log that was cut off is read up to there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.logs.blocks import LogBlocks
from omnimate.logs.formats.candump_blocks import SkippedLine
from omnimate.logs.formats.candump_lines import STAMP_WIDTH
from omnimate.logs.frames import Frames, concatenate
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike

GROWING = 0.8  # share of relative times that are later than the one before: half of them by chance


@dataclass(frozen=True, slots=True)
class LogReadResult:
    """A log, as far as it can be read.

    Attributes:
        source: Path of the file.
        frames: The frames in the order of the file.
        skipped: Lines that were left out, and why.
        truncated: Whether the file ends in the middle of a line or of its compressed data.
        stamp_width: Number of characters of a time in the log, with which it is printed again.
        is_added_up: Whether the log has the time since the frame before (`candump -td`), which was added up.
    """

    source: Path
    frames: Frames
    skipped: tuple[SkippedLine, ...] = ()
    truncated: bool = False
    stamp_width: int = STAMP_WIDTH
    is_added_up: bool = False

    @property
    def is_whole(self) -> bool:
        """Whether every line was read to the end of the file."""
        return not self.skipped and not self.truncated

    def problems(self) -> Iterator[str]:
        """Yield in words what was left out, and where the clock runs backwards."""
        for line in self.skipped:
            yield f"{self.source}:{line.line}: skipped: {line.reason}: {line.text!r}"
        if self.is_added_up:
            yield f"{self.source}: times are since the frame before (candump -td); they were added up from 0"
        if self.truncated:
            yield f"{self.source}: the log ends early; it was read up to there"
        jumps = self.frames.backwards().tolist()
        if jumps:
            before, after = self.frames.time[jumps[0] - 1 : jumps[0] + 1].tolist()
            where = f"first at frame {jumps[0] + 1} from {before:.6f} s to {after:.6f} s"
            yield f"{self.source}: the clock goes back {len(jumps)} times, {where}"


def read_log(path: Path | str, *, strict: bool = False) -> LogReadResult:
    """Return the frames of a log file of any known format.

    Args:
        path: Path of the file; its content decides on the format, not its suffix.
        strict: Whether a log is refused that cannot be read completely.

    Raises:
        LogError: There is no such file, it holds no frame, or `strict` is set and a line was left out.
    """
    path = Path(path)
    try:
        result = _read(path)
    except OSError as error:
        raise LogError(path, None, f"cannot be read: {error.strerror or error}") from error
    if len(result.frames) == 0:
        empty = SkippedLine(1, "", "it ends before the first" if result.truncated else "it is empty")
        first = result.skipped[0] if result.skipped else empty
        raise LogError(path, first.line, f"no CAN frame in the whole file; {first.reason}: {first.text!r}")
    if strict and not result.is_whole:
        line = result.skipped[0].line if result.skipped else None
        raise LogError(path, line, next(result.problems()).removeprefix(f"{path}:"))
    return result


def _read(path: Path) -> LogReadResult:
    blocks = LogBlocks(path)
    frames = concatenate(list(blocks))
    width = blocks.parser.stamp_width or STAMP_WIDTH
    added_up = blocks.parser.is_relative and is_since_last(frames.time)
    if added_up:
        frames = replace(frames, time=np.cumsum(frames.time))
    return LogReadResult(path, frames, tuple(blocks.skipped), blocks.truncated, width, added_up)


def is_since_last(time: ArrayLike) -> bool:
    """Say whether times are each since the frame before, and not all since the first one.

    The latter grow, but for frames of several interfaces that are written in another order.
    """
    grows = np.diff(np.asarray(time, np.float64)[1:]) > 0.0
    return len(grows) > 0 and float(np.mean(grows)) < GROWING
