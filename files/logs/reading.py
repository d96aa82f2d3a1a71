"""Reading of bus logs of all supported formats, recognised by their content.

candump (`-L`, `-ta`, `-td`, `-tz` and plain columns), Vector `.asc` and `.blf`, PEAK `.trc`, IXXAT MiniMon,
PCAP and PCAPNG, python-can's CSV, ASAM MF4; gzipped or not. What cannot be read is left out and reported line
by line; a log that was cut off is read up to there.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from omnimate.files.logs.blocks import LogBlocks
from omnimate.files.logs.frames import Frames, concatenate


class LogReadResult(NamedTuple):
    """The readable part of a log.

    Attributes:
        frames: The frames in the order of the file.
        blocks: The blocks in which it was read, and what was left out of them.
    """

    frames: Frames
    blocks: LogBlocks


def read_log(path: Path | str) -> LogReadResult:
    """Return the frames of a log file of any known format.

    Args:
        path: Path of the file; its content decides on the format, not its suffix.

    Raises:
        LogError: There is no such file, or it holds no frame.
    """
    blocks = LogBlocks(Path(path))
    return LogReadResult(concatenate(list(blocks)), blocks)
