"""Compiled reading of regular lines of `candump -L`, in several threads."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.frames import DEFAULT_CHANNEL, EXTENDED, RECEIVED, SENT, Frames, tail_of
from omnimate.vehicle.compiled import compiled_without_lock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frame

    Bytes = NDArray[np.uint8]
    Integers = NDArray[np.int64]

_MAX_NAME_LENGTH = 32  # bytes of an interface's name; longer ones are read line by line
_MAX_TIME_LENGTH = 22  # bytes: two brackets, ten digits, a point, nine digits
_OPEN, _CLOSE, _POINT, _HASH, _SPACE, _RETURN, _NEWLINE = b"().# \r\n"
_PADDING = b"\n" * 64  # after a block: look-ahead is at most a name
_R, _T = b"RT"
_STANDARD_DIGITS, _EXTENDED_DIGITS = 3, 8  # digits of an identifier
_MAX_STANDARD_ID, _MAX_EXTENDED_ID = 0x7FF, 0x1FFFFFFF
_EXTENDED, _RECEIVED, _SENT = EXTENDED, RECEIVED, SENT
_HEXADECIMAL = np.full(256, 255)  # value of a character as a digit; 255 for no digit
_HEXADECIMAL[np.frombuffer(b"0123456789ABCDEF", np.uint8)] = np.arange(16)
_HEXADECIMAL[np.frombuffer(b"abcdef", np.uint8)] = np.arange(10, 16)
_DECIMAL = np.where(_HEXADECIMAL < 10, _HEXADECIMAL, 255)
_POWERS, _WHOLE_POWERS = 10.0 ** np.arange(10), 10 ** np.arange(10)


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
        self.long: dict[int, bytes] = {}  # data of more than eight bytes, by row

    def put(self, row: int, frame: Frame, channel: int) -> None:
        """Fill in one line."""
        self.is_frame[row] = True
        self.time[row], self.can_id[row] = frame.time, frame.can_id
        self.length[row] = frame.size
        self.data[row, : len(frame.data)] = np.frombuffer(frame.data[:8], np.uint8)
        if len(frame.data) > 8:
            self.long[row] = frame.data
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
            tail_of(len(self.time), self.long),
        )
        return frames if self.is_frame.all() else frames.select(self.is_frame)


class Scanned(NamedTuple):
    """A block of lines, of which the regular ones were read.

    The table has one row per line, and `starts` the first byte of each line, `(N,)`.
    """

    block: bytes
    table: Table
    starts: NDArray[np.int64]


def scan(block: bytes, channels: Sequence[str]) -> Scanned:
    """Read the regular lines of a block without holding Python's lock.

    It is whole lines, the last newline included; interfaces that are known are in the order of their numbers.
    """
    names = np.zeros((max(1, len(channels)), _MAX_NAME_LENGTH), np.uint8)
    sizes = np.zeros(len(names), np.int64)
    for number, channel in enumerate(channels):
        name = channel.encode()
        if len(name) <= _MAX_NAME_LENGTH:
            names[number, : len(name)], sizes[number] = np.frombuffer(name, np.uint8), len(name)
    text = np.frombuffer(block + _PADDING, np.uint8)
    count = int(np.count_nonzero(text == _NEWLINE)) - len(_PADDING)
    table, starts = Table(count), np.empty(count, np.int64)
    data = table.data.reshape(-1)
    columns = (table.is_frame, table.time, table.can_id, table.length, data, table.flags, table.channel)
    _scan(text, names, sizes, starts, *columns)
    return Scanned(block, table, starts)


@compiled_without_lock
def _scan(
    text: Bytes,
    names: Bytes,
    sizes: Integers,
    starts: Integers,
    is_frame: NDArray[np.bool_],
    time: NDArray[np.float64],
    can_id: NDArray[np.uint32],
    length: Bytes,
    data: Bytes,
    flags: Bytes,
    channel: Bytes,
) -> None:
    """Fill in a row of the arrays for each regular line, and where each line starts.

    The point and the end of the time are looked for where they were in the line before.
    """
    position, point, close = 0, 11, 18
    for row in range(len(starts)):
        starts[row] = position
        if text[position + close] != _CLOSE or text[position + point] != _POINT:
            point, close = _time_at(text, position)
        at, number = _name_at(text, position + close, names, sizes)
        identifier, width, at = _identifier_at(text, at)
        size = _data_at(text, at, data, 8 * row)
        flag, end = _direction_at(text, at + 2 * size)
        seconds = _number(text, position + 1, position + point)
        fraction = _number(text, position + point + 1, position + close)
        is_frame[row] = (
            end > 0
            and width > 0
            and number >= 0
            and seconds >= 0
            and fraction >= 0
            and text[position] == _OPEN
        )
        if is_frame[row]:
            decimals = close - point - 1
            time[row] = (seconds * _WHOLE_POWERS[decimals] + fraction) / _POWERS[decimals]
            can_id[row], length[row], channel[row] = identifier, size, number
            flags[row] = flag | (_EXTENDED if width == _EXTENDED_DIGITS else 0)
        else:
            data[8 * row : 8 * row + 8] = 0
            end = position
            while text[end] != _NEWLINE:
                end += 1
        position = end + 1


def _time_at(text: Bytes, position: int) -> tuple[int, int]:
    """Return where the point and the end of a time are, from the start of its line; 0 and 0 for none."""
    point = at = 0
    while text[position + at] != _NEWLINE and at < _MAX_TIME_LENGTH:
        if text[position + at] == _POINT:
            point = at
        if text[position + at] == _CLOSE:
            return (point, at) if 2 <= point <= 11 and 2 <= at - point <= 10 else (0, 0)
        at += 1
    return 0, 0


def _number(text: Bytes, begin: int, end: int) -> int:
    """Return the number that digits are, taken two at a time; -1 where one is no digit, or where is none."""
    value, wrong = 0, 0 if end > begin else 1
    if (end - begin) % 2:
        value = _DECIMAL[text[begin]]
        wrong |= value >> 4
    for at in range(begin + (end - begin) % 2, end, 2):
        first, second = _DECIMAL[text[at]], _DECIMAL[text[at + 1]]
        wrong |= (first | second) >> 4  # no digit has these bits
        value = value * 100 + first * 10 + second
    return -1 if wrong else value


def _name_at(text: Bytes, close: int, names: Bytes, sizes: Integers) -> tuple[int, int]:
    """Return what stands behind the interface's name, and its number; -1 for a name that is not known."""
    at = close + 1
    while text[at] == _SPACE:
        at += 1
    for number in range(len(sizes)):
        size = sizes[number]
        if size == 0 or at == close + 1 or text[at + size] != _SPACE:
            continue
        place = 0
        while place < size and text[at + place] == names[number, place]:
            place += 1
        if place == size:
            at += size
            while text[at] == _SPACE:
                at += 1
            return at, number
    return at, -1


def _identifier_at(text: Bytes, at: int) -> tuple[int, int, int]:
    """Return an identifier, the number of its digits, and what stands behind the `#`; no digits for none."""
    width = _STANDARD_DIGITS if text[at + _STANDARD_DIGITS] == _HASH else _EXTENDED_DIGITS
    identifier = wrong = 0
    for place in range(at, at + width):
        digit = _HEXADECIMAL[text[place]]
        wrong |= digit >> 4
        identifier = identifier << 4 | digit
    highest = _MAX_STANDARD_ID if width == _STANDARD_DIGITS else _MAX_EXTENDED_ID
    if wrong or identifier > highest or text[at + width] != _HASH:
        return 0, 0, at
    return identifier, width, at + width + 1


def _data_at(text: Bytes, at: int, data: Bytes, begin: int) -> int:
    """Read pairs of digits into bytes from `begin` on, at most 8, and return their number."""
    size = 0
    while size < 8:
        high, low = _HEXADECIMAL[text[at]], _HEXADECIMAL[text[at + 1]]
        if (high | low) >> 4:
            break
        data[begin + size] = high << 4 | low
        size += 1
        at += 2
    return size


def _direction_at(text: Bytes, at: int) -> tuple[int, int]:
    """Return the flag of `R` or `T` behind the data, and where the newline is; 0 where there is more."""
    flag = 0
    if text[at] == _SPACE and text[at + 1] in {_R, _T}:
        flag = _RECEIVED if text[at + 1] == _R else _SENT
        at += 2
    if text[at] == _RETURN:
        at += 1
    return (flag, at) if text[at] == _NEWLINE else (0, 0)
