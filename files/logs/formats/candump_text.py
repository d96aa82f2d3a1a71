"""Fast formatting of frames as candump prints them, by columns; equal to `format_frame` line by line.

All frames of a kind (interface, flags, length) have lines of one shape. `format_frame` gives the line of one
of them; in a copy of it for each frame the digits of time, identifier and data are replaced. Frames of CAN FD
are few in logs of CANopen: `format_frame` gives each of their lines.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.formats.candump_lines import ERROR_BIT, STAMP_WIDTH, Form, format_frame
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames

    Characters = NDArray[np.uint8]

BLOCK_FRAMES = 1 << 15  # frames written at a time: their lines stay in the processor's cache
MICROSECONDS = 7  # characters: a point and six digits
ROUNDING_MARGIN = 0.05  # [us] from a tie between two microseconds, within which rounding may differ


def _table(count: int, text: str) -> Characters:
    """Return the characters of `text % n` for each n, shape `(count, width)`."""
    return np.frombuffer("".join(text % number for number in range(count)).encode(), np.uint8).reshape(
        count, -1
    )


_DECIMAL = _table(10_000, "%04d")
_IDENTIFIER = _table(0x800, "%03X")
_BYTE = _table(0x100, "%02X")


def candump_text(
    frames: Frames, form: Form = "log", stamp_width: int = STAMP_WIDTH, *, indent: bool = False
) -> Iterator[bytes]:
    """Yield the text of a log in pieces of many lines, each with its newline.

    The arguments are those of `format_lines`.
    """
    width = max(len(name) for name in frames.channels)
    extended = np.flatnonzero(frames.flags & EXTENDED)
    first = 0 if indent else int(extended[0]) if len(extended) else len(frames)
    starts = sorted({*range(0, len(frames), BLOCK_FRAMES), first} - {len(frames)})
    for start, end in zip(starts, [*starts[1:], len(frames)], strict=True):
        block = frames.select(slice(start, end))
        yield _text(block, form, width, stamp_width, indent=start >= first)


def _text(frames: Frames, form: Form, width: int, stamp_width: int, *, indent: bool) -> bytes:
    """Return the lines of a block as text; a zero stands for no character."""
    exact = frames.time * 1e6
    micros = np.rint(exact)
    odd = (
        (np.abs(exact - micros) > 0.5 - ROUNDING_MARGIN)
        | (micros < 0)
        | (micros >= 10.0 ** (stamp_width - 1))
    )
    is_fd = frames.flags & FD > 0
    odd |= is_fd
    kinds = frames.channel.astype(np.int32) << 12 | frames.flags.astype(np.int32) << 4 | frames.length
    kinds[is_fd] = -1
    present = np.flatnonzero(np.bincount(kinds[~is_fd])).tolist()
    lines: list[tuple[NDArray[np.intp], Characters]] = []
    for kind in present:
        rows = np.flatnonzero(kinds == kind)
        group = frames if len(rows) == len(frames) else frames.select(rows)
        lines.append((rows, _lines(group, form, width, stamp_width, indent=indent)))
    special = np.flatnonzero(odd)
    special_lines = {
        row: format_frame(frame, form, width, indent=indent, stamp_width=stamp_width).encode() + b"\n"
        for row, frame in zip(special.tolist(), frames.select(special), strict=True)
    }
    longest = max(
        [line.shape[1] for _, line in lines] + [len(special_line) for special_line in special_lines.values()]
    )
    text = np.zeros((len(frames), longest), np.uint8)
    for rows, line in lines:
        text[rows, : line.shape[1]] = line
    stamp = 1 if form == "log" else 2
    _fill_stamps(text[:, stamp : stamp + stamp_width], np.where(odd, 0.0, micros))
    for row, special_line in special_lines.items():
        text[row] = np.frombuffer(special_line.ljust(longest, b"\0"), np.uint8)
    return text.tobytes().translate(None, b"\0")


def _lines(frames: Frames, form: Form, width: int, stamp_width: int, *, indent: bool) -> Characters:
    """Return the lines of frames of one kind, shape `(N, line)`, with their newlines and time 0."""
    frame = next(iter(frames.select(slice(1))))._replace(time=0.0)
    line = format_frame(frame, form, width, indent=indent, stamp_width=stamp_width).encode() + b"\n"
    text = np.empty((len(frames), len(line)), np.uint8)
    text[:] = np.frombuffer(line, np.uint8)
    if form == "ta":
        end, data, step = line.rindex(b"[") - 3, line.rindex(b"]") + 3, 3
    else:
        end, data, step = line.rindex(b"#"), line.rindex(b"#") + 1, 2
    _fill_identifiers(text[:, :end], frames.can_id, int(frame.flags))
    size = 0 if frame.flags & REMOTE else len(frame.data)
    digits = _BYTE[frames.data[:, :size]]
    for place in range(2):
        text[:, data + place : data + place + step * size : step] = digits[:, :, place]
    return text


def _fill_stamps(place: Characters, micros: NDArray[np.float64]) -> None:
    """Write times [us] as seconds with six decimals into columns of characters; the point is there."""
    whole = np.floor(micros / 1e6)
    rest = (micros - whole * 1e6).astype(np.uint32)
    place[:, -6:-2] = _DECIMAL[rest // 100]
    place[:, -2:] = _DECIMAL[rest % 100, 2:]
    columns = place[:, :-MICROSECONDS]
    for end in range(columns.shape[1], 0, -4):
        upper = np.floor(whole / 1e4)
        digits = _DECIMAL[(whole - upper * 1e4).astype(np.uint32)]
        columns[:, max(0, end - 4) : end] = digits[:, max(0, 4 - end) :]
        whole = upper


def _fill_identifiers(place: Characters, can_id: NDArray[np.uint32], flags: int) -> None:
    """Write identifiers into the last columns of characters."""
    if flags & (EXTENDED | ERROR):
        whole = can_id | np.uint32(ERROR_BIT if flags & ERROR else 0)
        place[:, -8:] = _BYTE[whole.astype(">u4").view(np.uint8).reshape(-1, 4)].reshape(-1, 8)
    else:
        place[:, -3:] = _IDENTIFIER[can_id]
