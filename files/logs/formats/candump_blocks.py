"""Fast reading of `candump -L` logs, block by block.

Compiled code reads regular lines (`candump_kernel`), the line parser all others.
"""

from __future__ import annotations

import itertools
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.formats.candump_kernel import scan
from omnimate.files.logs.formats.candump_lines import LOG_LINE, STAMP, is_comment, parse_line, refuse_fd

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from concurrent.futures import Future

    from omnimate.files.logs.formats.candump_kernel import Scanned, Table
    from omnimate.files.logs.frames import Frames

RELATIVE_WIDTH = 10  # characters of a relative time on candump's screen: three digits, a point, six digits
_MAX_NEW_CHANNELS = 16  # new interfaces that are searched for in one block
_MAX_CHANNELS = 256
_EXCERPT_LENGTH = 80  # characters of a skipped line that are stored


class SkippedLine(NamedTuple):
    """A line that was left out.

    The line is counted from 1, the text is its beginning; the reason is empty where nothing but the rest of
    the file is missing, and `is_end` says that the file ends here, in the middle.
    """

    line: int
    text: str
    reason: str
    is_end: bool = False


@dataclass(slots=True)
class BlockParser:
    """Reads a log block by block; a block is whole lines, the last newline included.

    `fd`: CAN FD frames are read too, and not skipped; `channels` are the interfaces so far with their
    numbers; `stamp_width` has the characters of the first time in the log, 0 before it, which `is_relative`
    as of `candump -td` or `-tz`; `skipped` lines hold no frame.
    """

    fd: bool = False
    channels: dict[str, int] = field(default_factory=dict)
    lines: int = 0
    stamp_width: int = 0
    is_relative: bool = False
    skipped: list[SkippedLine] = field(default_factory=list)

    def has_relative_times(self, block: bytes) -> bool:
        """Return whether a log that begins with this block has times as of `candump -td` or `-tz`."""
        first = STAMP.search(block)
        if not self.stamp_width and first:
            self.stamp_width = len(first[1])
            self.is_relative = self.stamp_width == RELATIVE_WIDTH and first[2] is not None
        return self.is_relative

    def parse(self, block: bytes) -> Frames:
        """Return the frames of a block."""
        for _ in range(_MAX_NEW_CHANNELS):
            scanned = scan(block, tuple(self.channels))
            name = _unread_name(scanned)
            if name is None or name in self.channels or self._number(name) is None:
                break
        return self.finish(scanned)

    def finish(self, scanned: Scanned) -> Frames:
        """Return the frames of a block whose regular lines are read already, after reading the others."""
        block, table, starts = scanned
        ends = np.append(starts[1:], len(block))
        for row in np.flatnonzero(~table.is_frame).tolist():
            line = block[starts[row] : ends[row] - 1]
            if not is_comment(line):
                self._parse_line(line, row, table)
        self.has_relative_times(block)
        self.lines += len(starts)
        return table.frames(tuple(self.channels))

    def _parse_line(self, line: bytes, row: int, table: Table) -> None:
        frame = refuse_fd(parse_line(line), fd=self.fd)
        number = None if isinstance(frame, str) else self._number(frame.channel)
        if isinstance(frame, str):
            self.skipped.append(skipped_line(self.lines + row + 1, line, frame))
        elif number is None:
            reason = f"more than {_MAX_CHANNELS} interfaces in one log"
            self.skipped.append(skipped_line(self.lines + row + 1, line, reason))
        else:
            table.put(row, frame, number)

    def _number(self, channel: str) -> int | None:
        """Return an interface's number; None where there are too many."""
        if channel not in self.channels and len(self.channels) >= _MAX_CHANNELS:
            return None
        return self.channels.setdefault(channel, len(self.channels))


def skipped_line(line: int, text: bytes, reason: str, *, is_end: bool = False) -> SkippedLine:
    """Return a line that holds no frame, with the beginning of its text."""
    return SkippedLine(line, text[:_EXCERPT_LENGTH].decode(errors="replace").rstrip(), reason, is_end)


def _unread_name(scanned: Scanned) -> str | None:
    """Return the interface of the first line that was not read though it is regular."""
    for row in np.flatnonzero(~scanned.table.is_frame)[:_MAX_NEW_CHANNELS].tolist():
        begin = int(scanned.starts[row])
        match = LOG_LINE.fullmatch(scanned.block[begin : scanned.block.index(b"\n", begin)])
        if match is not None and isinstance(parse_line(match[0]), tuple):
            return match[2].decode(errors="replace")
    return None


def parse_in_parallel(blocks: Iterable[bytes], parser: BlockParser, workers: int) -> Iterator[Frames]:
    """Yield the frames of each block, in order; what is in memory are a few blocks per worker.

    The first block shows the interfaces.

    Blocks are whole lines, each with its last newline.
    """
    coming = iter(blocks)
    for block in itertools.islice(coming, 1):
        yield parser.parse(block)
    with ThreadPoolExecutor(workers) as pool:
        scanning: deque[Future[Scanned]] = deque()
        for block in coming:
            scanning.append(pool.submit(scan, block, tuple(parser.channels)))
            if len(scanning) > 2 * workers:
                yield parser.finish(scanning.popleft().result())
        while scanning:
            yield parser.finish(scanning.popleft().result())
