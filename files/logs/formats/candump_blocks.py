"""`candump -L` logs of millions of frames, parsed column by column with numpy.

The lines of a block are grouped by their length. The first line of a group gives its shape: the columns
in which the digits stand. All lines of this shape are then read at once; whatever does not fit it
(another interface, a remote frame, garbage) is the next round's, or is read by the careful line parser.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from omnimate.files.logs.formats.candump_lines import LOG_LINE, ONLY_CLASSICAL, STAMP, parse_line
from omnimate.files.logs.frames import DEFAULT_CHANNEL, EXTENDED, FD, RECEIVED, SENT, Frames

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frame

RELATIVE_WIDTH = 10  # characters of a relative time on candump's screen: three digits, a point, six digits
_NEWLINE, _ZERO = 10, 48
_FEW = 8  # lines: below this the careful parser is quicker
_ROUNDS = 16  # shapes tried per line length
_MAX_CHANNELS = 256
_LONGEST = 80  # bytes of the longest regular line: no need to look for columns in others
_TEXT = 80  # characters of a skipped line that are kept

# What a character is worth as a hexadecimal digit; 255 for no digit.
NIBBLE = np.full(256, 255, np.uint8)
NIBBLE[np.frombuffer(b"0123456789ABCDEF", np.uint8)] = np.arange(16)
NIBBLE[np.frombuffer(b"abcdef", np.uint8)] = np.arange(10, 16)
_NO_PAIR = 0x100
_FD_MARK = b"##"  # between identifier and data of a CAN FD frame


def _pairs(base: int) -> NDArray[np.uint16]:
    """Return what two characters, as one little-endian number, are worth as digits; `_NO_PAIR` for none."""
    digits = NIBBLE.astype(np.uint16)
    first, second = digits[None, :], digits[:, None]  # the first character is the lower byte
    return (
        np.where((first < base) & (second < base), first * base + second, _NO_PAIR)
        .reshape(-1)
        .astype(np.uint16)
    )


_HEXADECIMAL, _DECIMAL = _pairs(16), _pairs(10)


class SkippedLine(NamedTuple):
    """A line that was left out.

    Attributes:
        line: Number of the line, from 1.
        text: Beginning of the line.
        reason: Why the line was left out; empty where nothing but the rest of the file is missing.
        is_end: Whether the file ends here, in the middle.
    """

    line: int
    text: str
    reason: str
    is_end: bool = False


class _Shape(NamedTuple):
    """Where the digits of a line stand; every other character is the same in all lines of the shape."""

    stamp: NDArray[np.intp]
    divisor: float
    identifier: NDArray[np.intp]
    data: NDArray[np.intp]
    constant: NDArray[np.intp]
    channel: str
    flags: int


@dataclass(slots=True)
class BlockParser:
    """Reads a log block by block; a block is whole lines, the last newline included.

    Attributes:
        channels: Names of the interfaces so far, with their numbers.
        lines: Number of lines read so far.
        stamp_width: Number of characters of the first time in the log; 0 before it.
        is_relative: Whether it is a time as of `candump -td` or `-tz`, which are not absolute.
        skipped: Lines that hold no frame.
    """

    channels: dict[str, int] = field(default_factory=dict)
    lines: int = 0
    stamp_width: int = 0
    is_relative: bool = False
    skipped: list[SkippedLine] = field(default_factory=list)

    def each(self, block: bytes) -> Iterator[Frame]:
        """Yield the frames of a block, those of CAN FD too."""
        if _FD_MARK not in block:
            yield from self.parse(block)
            return
        for line in block.splitlines():
            self.lines += 1
            frame = parse_line(line) if line.strip() else None
            if isinstance(frame, str):
                self.skip(self.lines, line, frame)
            elif frame is not None:
                yield frame

    def has_relative_times(self, block: bytes) -> bool:
        """Return whether a log that begins with this block has times as of `candump -td` or `-tz`."""
        first = STAMP.search(block)
        if not self.stamp_width and first:
            self.stamp_width = len(first[1])
            self.is_relative = self.stamp_width == RELATIVE_WIDTH and first[2] is not None
        return self.is_relative

    def parse(self, block: bytes) -> Frames:
        """Return the classical frames of a block."""
        characters = np.frombuffer(block, np.uint8)
        ends = np.flatnonzero(characters == _NEWLINE)
        starts = np.concatenate(([0], ends[:-1] + 1))
        table = Table(len(ends))
        lengths = ends - starts
        for length in np.flatnonzero(np.bincount(lengths)).tolist():
            self._parse_group(block, characters, starts, np.flatnonzero(lengths == length), length, table)
        self.has_relative_times(block)
        self.lines += len(ends)
        return table.frames(tuple(self.channels))

    def finish(self, block: bytes, table: Table, starts: NDArray[np.int64]) -> Frames:
        """Return the frames of a block whose regular lines are read already, after reading the others.

        Args:
            block: Whole lines, the last newline included.
            table: The frames of the regular lines, one row per line.
            starts: First byte of each line, `(N,)`.
        """
        ends = np.append(starts[1:], len(block))
        for row in np.flatnonzero(~table.is_frame).tolist():
            line = block[starts[row] : ends[row] - 1]
            if line.strip():
                self._parse_line(line, row, table)
        self.has_relative_times(block)
        self.lines += len(starts)
        return table.frames(tuple(self.channels))

    def _parse_group(
        self,
        block: bytes,
        characters: NDArray[np.uint8],
        starts: NDArray[np.intp],
        group: NDArray[np.intp],
        length: int,
        table: Table,
    ) -> None:
        """Fill in the lines `group`, which are all of one length."""
        for _ in range(_ROUNDS):
            if len(group) < _FEW or length > _LONGEST:
                break
            first = int(starts[group[0]])
            shape = _shape_of(block[first : first + length])
            if shape is None or self._number(shape.channel) is None:
                self._parse_lines(block, starts, group[:1], length, table)
                group = group[1:]
                continue
            rows = sliding_window_view(characters, length)[starts[group]]
            group = group[~table.fill(group, rows, shape, self.channels[shape.channel])]
        self._parse_lines(block, starts, group, length, table)

    def _parse_lines(
        self, block: bytes, starts: NDArray[np.intp], group: NDArray[np.intp], length: int, table: Table
    ) -> None:
        for row, start in zip(group.tolist(), starts[group].tolist(), strict=True):
            line = block[start : start + length]
            if line.strip():
                self._parse_line(line, row, table)

    def _parse_line(self, line: bytes, row: int, table: Table) -> None:
        frame = parse_line(line)
        if not isinstance(frame, str) and frame.flags & FD:
            frame = ONLY_CLASSICAL
        number = None if isinstance(frame, str) else self._number(frame.channel)
        if isinstance(frame, str):
            self.skip(self.lines + row + 1, line, frame)
        elif number is None:
            self.skip(self.lines + row + 1, line, f"more than {_MAX_CHANNELS} interfaces in one log")
        else:
            table.put(row, frame, number)

    def _number(self, channel: str) -> int | None:
        """Return an interface's number; None where there are too many."""
        if channel not in self.channels and len(self.channels) >= _MAX_CHANNELS:
            return None
        return self.channels.setdefault(channel, len(self.channels))

    def skip(self, line: int, text: bytes, reason: str) -> None:
        """Note a line that holds no frame."""
        self.skipped.append(SkippedLine(line, text[:_TEXT].decode(errors="replace").rstrip(), reason))


class Table:
    """The frames of a block while it is read, one row per line."""

    def __init__(self, count: int) -> None:
        self.is_frame = np.zeros(count, bool)
        self.time = np.empty(count, np.float64)
        self.can_id = np.empty(count, np.uint32)
        self.length = np.empty(count, np.uint8)
        self.data = np.zeros((count, 8), np.uint8)
        self.flags = np.empty(count, np.uint8)
        self.channel = np.empty(count, np.uint8)

    def fill(
        self, group: NDArray[np.intp], rows: NDArray[np.uint8], shape: _Shape, channel: int
    ) -> NDArray[np.bool_]:
        """Read the lines `rows` (K, L) that have a shape, and say which have it, `(K,)`."""
        fits: NDArray[np.bool_] = _all_of_row(rows[:, shape.constant] == rows[0, shape.constant])
        stamp = _digits(rows, shape.stamp, _DECIMAL, fits)
        identifier = _digits(rows, shape.identifier, _HEXADECIMAL, fits)
        pairs = _digits(rows, shape.data, _HEXADECIMAL, fits)
        can_id = _number(identifier, 256)
        fits &= can_id <= (0x1FFFFFFF if shape.flags & EXTENDED else 0x7FF)
        time = _number(stamp, 100) / shape.divisor
        if not fits.all():
            group, time, can_id, pairs = group[fits], time[fits], can_id[fits], pairs[fits]
        self.is_frame[group] = True
        self.time[group] = time
        self.can_id[group] = can_id
        self.data[group, : pairs.shape[1]] = pairs
        self.length[group], self.flags[group], self.channel[group] = pairs.shape[1], shape.flags, channel
        return fits

    def put(self, row: int, frame: Frame, channel: int) -> None:
        """Fill in one line."""
        self.is_frame[row] = True
        self.time[row], self.can_id[row] = frame.time, frame.can_id
        self.length[row] = len(frame.data) if frame.length is None else frame.length
        self.data[row, : len(frame.data)] = np.frombuffer(frame.data, np.uint8)
        self.flags[row], self.channel[row] = frame.flags, channel

    def frames(self, channels: tuple[str, ...]) -> Frames:
        """Return the lines that hold frames."""
        frames = Frames(
            self.time,
            self.can_id,
            self.length,
            self.data,
            self.flags,
            self.channel,
            channels or (DEFAULT_CHANNEL,),
        )
        return frames if self.is_frame.all() else frames.select(self.is_frame)


def _digits(
    rows: NDArray[np.uint8], columns: NDArray[np.intp], table: NDArray[np.uint16], fits: NDArray[np.bool_]
) -> NDArray[np.uint16]:
    """Return the worth of every two characters of some columns, and clear `fits` where they are no digits.

    An odd number of columns has a zero before the first.
    """
    odd = len(columns) % 2
    characters = np.full((len(rows), len(columns) + odd), _ZERO, np.uint8)
    characters[:, odd:] = rows[:, columns]
    pairs: NDArray[np.uint16] = table[characters.view("<u2")]
    if pairs.size and pairs.max() == _NO_PAIR:
        fits &= (pairs != _NO_PAIR).all(axis=1)
    return pairs


def _number(digits: NDArray[np.uint16], base: int) -> NDArray[np.int64]:
    """Return the numbers that rows of digits are, shape `(K,)`."""
    value = digits[:, 0].astype(np.int64)
    for place in range(1, digits.shape[1]):
        value *= base
        value += digits[:, place]
    return value


def _all_of_row(right: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which rows are right in every column; as a rule all of them are, which is quicker to see."""
    return np.ones(len(right), bool) if right.all() else np.asarray(right.all(axis=1))


def _shape_of(line: bytes) -> _Shape | None:
    """Return the shape of a regular line; None where it holds anything but two digits per byte."""
    match = LOG_LINE.fullmatch(line)
    if match is None:
        return None
    identifier, data = np.arange(*match.span(3)), np.arange(*match.span(4))
    size = len(data)
    if (
        match.end(3) - match.start(3) not in {3, 8}
        or size > 16
        or size % 2
        or b"." in match[4]
        or b"_" in match[4]
    ):
        return None
    point = match.start(1) + match[1].index(b".")
    stamp = np.r_[match.start(1) : point, point + 1 : match.end(1)]
    variable = np.r_[stamp, identifier, data]
    return _Shape(
        stamp,
        10.0 ** (match.end(1) - point - 1),
        identifier,
        data,
        np.setdiff1d(np.arange(len(line)), variable),
        match[2].decode(errors="replace"),
        (EXTENDED if len(match[3]) == 8 else 0) | {b"R": RECEIVED, b"T": SENT}.get(match[5], 0),
    )
