"""The line formats of candump (can-utils), read and written line by line.

`log` is what `candump -L` prints, `(1700000000.000250) can0 181#0010000000200000`; `ta` is what
`candump -ta` prints, ` (1700000000.000250)  can0  181   [8]  00 10 00 00 00 20 00 00`, its leading
space included. With `-x` both say whether a frame was received or sent. Also read is the plain form
`1700000000.000250 can0 181 [8] 00 10 00 00 00 20 00 00` of other recorders, with or without the length, with
or without spaces between the bytes. Times may be dates, as of `candump -tA`, in this computer's time zone.
"""

from __future__ import annotations

import re
from datetime import datetime
from typing import TYPE_CHECKING, Literal

from omnimate.files.logs.frames import BRS, ERROR, ESI, EXTENDED, FD, RECEIVED, REMOTE, SENT, Frame

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.logs.frames import Frames

Form = Literal["log", "ta"]

STAMP_WIDTH = 17  # characters of the time that candump prints: ten digits, a point, six digits

_DIRECTION = RECEIVED | SENT
_LOG_DIRECTIONS = {RECEIVED: " R", SENT: " T"}
_TA_DIRECTIONS = {RECEIVED: "  RX", SENT: "  TX"}
_PARSED_DIRECTIONS = {b"R": RECEIVED, b"T": SENT, b"RX": RECEIVED, b"TX": SENT, None: 0}
ERROR_BIT = 0x20000000  # CAN_ERR_FLAG of linux/can.h, printed as part of the identifier

LOG_LINE = re.compile(rb"\((\d{1,10}\.\d{1,9})\) +(\S+) +([0-9A-Fa-f]+)#(\S*)(?: ([RT]))?\s*")
_TA_LINE = re.compile(
    rb"\s*\((\d{1,10}\.\d{1,9})\)\s+(\S+)\s+(?:(RX|TX) [B-] [E-]\s+)?([0-9A-Fa-f]+)\s+"
    rb"(\[\d\]|\[\d\d\]|\{[0-9A-F]\}) ?( remote request|(?: [0-9A-Fa-f]{2})*)(?:\s.*)?"
)
_PLAIN_LINE = re.compile(
    rb"\s*\(?(\d{1,10}\.\d{1,9})\)?\s+(\S+)\s+(?:0[xX])?([0-9A-Fa-f]{1,8})(?:\s+\[?(\d)\]?(?=\s|$))?"
    rb"((?:\s+(?:[0-9A-Fa-f]{2})+)*)\s*"
)
STAMP = re.compile(rb"\((\d{1,10}\.\d{6})\)(  )?")  # the screen's two spaces behind it
_DATE = re.compile(rb"\s*\((\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{6})\)")
_COMMENT = re.compile(rb"(?:\t[a-z-]+(?:\{.*\})?)?\s*")  # behind a tab: of `candump -e`
_REMOTE_TAIL = re.compile(rb"[Rr]([0-8])?")
_DATA_TAIL = re.compile(rb"((?:[0-9A-Fa-f]{2}\.?)*)(?:_[9A-Fa-f])?")
_FD_TAIL = re.compile(rb"#([0-9A-Fa-f])((?:[0-9A-Fa-f]{2}\.?)*)")
CANFD_BRS, CANFD_ESI, CANFD_FDF = 1, 2, 4  # of linux/can.h; the digit before the data of a CAN FD frame
ONLY_CLASSICAL = "a CAN FD frame; only classical CAN is read"
FD_LENGTHS = (*range(9), 12, 16, 20, 24, 32, 48, 64)  # bytes, ISO 11898-1
_NO_TIME = re.compile(rb"\s*\S+\s+[0-9A-Fa-f]+\s+\[\d\].*|\s*\S+ +[0-9A-Fa-f]+#\S*\s*")


def format_frame(
    frame: Frame,
    form: Form = "log",
    width: int = 0,
    *,
    indent: bool = False,
    stamp_width: int = STAMP_WIDTH,
) -> str:
    """Return a frame as candump prints it, without the newline.

    `width` is that to which candump right-aligns the interface's
    name, where it shows several; `indent` right-aligns 11-bit identifiers, as `-ta` does after a 29-bit one;
    the time has `stamp_width` characters, filled up with zeros.
    """
    if form == "log" and not (frame.flags or width or stamp_width != STAMP_WIDTH):
        # what nearly every frame is, and what is written thousands of times a second
        return f"({frame.time:017.6f}) {frame.channel} {frame.can_id:03X}#{frame.data.hex().upper()}"
    if form == "log":
        content = f"{_identifier(frame)}#{_payload(frame)}{_LOG_DIRECTIONS.get(frame.flags & _DIRECTION, '')}"
        return f"({frame.time:0{stamp_width}.6f}) {frame.channel.rjust(width)} {content}"
    channel = frame.channel.rjust(width) + _ta_direction(frame.flags)
    identifier = f"{_identifier(frame):>8}" if indent else _identifier(frame)
    length = f" [{frame.size:02d}]" if frame.flags & FD else f"  [{frame.size}]"
    content = f"{identifier} {length} {_long_payload(frame)}"
    return f" ({frame.time:0{stamp_width}.6f})  {channel}  {content}"


def format_lines(
    frames: Frames, form: Form = "log", stamp_width: int = STAMP_WIDTH, *, indent: bool = False
) -> Iterator[str]:
    """Yield each frame as candump prints it, without the newline, names and identifiers aligned.

    As `format_frame`; `indent`: a frame with 29 bits came before, behind which identifiers stand further
    right.
    """
    width = max(len(name) for name in frames.channels)
    for frame in frames:
        indent = indent or bool(frame.flags & EXTENDED)
        yield format_frame(frame, form, width, indent=indent, stamp_width=stamp_width)


def parse_line(line: bytes) -> Frame | str:
    """Return the frame of a line in any of the forms, or the reason why it holds none."""
    line = _with_seconds(line)
    if match := LOG_LINE.fullmatch(line):
        stamp, channel, identifier, tail, direction = match.groups()
        return _frame(stamp, channel, identifier, _content(tail), _PARSED_DIRECTIONS[direction])
    if match := _TA_LINE.fullmatch(line):
        stamp, channel, direction, identifier, length, tail = match.groups()
        content = _long_content(length, tail)
        return _frame(stamp, channel, identifier, content, _PARSED_DIRECTIONS[direction])
    if match := _PLAIN_LINE.fullmatch(line):
        stamp, channel, identifier, length, tail = match.groups()
        if length or tail or b"(" not in line:  # else it is the beginning of a line as of `candump -L`
            return _frame(stamp, channel, _in_digits(identifier), _plain_content(length, tail), 0)
    if line.startswith(b"DROPCOUNT"):
        return "the recorder dropped frames here"
    if _NO_TIME.fullmatch(line):
        return "no time in it; record with `candump -L` or `candump -ta`"
    return "expected `(seconds) interface ID#DATA`, as `candump -L` prints"


def is_comment(line: bytes) -> bool:
    """Return whether a line is empty, or is what `candump -e` says of the error frame above it."""
    return _COMMENT.fullmatch(line) is not None


def refuse_fd(frame: Frame | str, *, fd: bool) -> Frame | str:
    """Return what was read, or where it is a CAN FD frame and `fd` is not wanted, that it is left out."""
    return ONLY_CLASSICAL if isinstance(frame, Frame) and frame.flags & FD and not fd else frame


def _with_seconds(line: bytes) -> bytes:
    """Return a line whose time is a date with its seconds since 1970, and any other as it is."""
    date = _DATE.match(line)
    try:
        seconds = 0.0 if date is None else datetime.fromisoformat(date[1].decode()).timestamp()
    except (ValueError, OverflowError):
        return line
    return line if date is None else b"(%.6f)%s" % (seconds, line[date.end() :])


def _identifier(frame: Frame) -> str:
    if frame.flags & ERROR:
        return f"{frame.can_id | ERROR_BIT:08X}"
    return f"{frame.can_id:08X}" if frame.flags & EXTENDED else f"{frame.can_id:03X}"


def _ta_direction(flags: int) -> str:
    """Return who sent a frame, if the log says so, and how a CAN FD frame was sent."""
    direction = _TA_DIRECTIONS.get(flags & _DIRECTION)
    if direction is None:
        return ""
    return f"{direction} {'B' if flags & BRS else '-'} {'E' if flags & ESI else '-'}"


def _payload(frame: Frame) -> str:
    if frame.flags & REMOTE:
        return f"R{frame.size}" if frame.size else "R"
    if frame.flags & FD:
        return f"#{fd_bits(frame.flags):X}{frame.data.hex().upper()}"
    return frame.data.hex().upper()


def fd_bits(flags: int) -> int:
    """Return the bits of linux/can.h that say how a CAN FD frame was sent."""
    return bool(flags & BRS) * CANFD_BRS | bool(flags & ESI) * CANFD_ESI


def fd_flags(bits: int) -> int:
    """Return the flags of a CAN FD frame with these bits of linux/can.h."""
    return FD | bool(bits & CANFD_BRS) * BRS | bool(bits & CANFD_ESI) * ESI


def _long_payload(frame: Frame) -> str:
    if frame.flags & REMOTE:
        return " remote request"
    text = "".join(f" {byte:02X}" for byte in frame.data)
    return text + "ERRORFRAME".rjust(3 * (8 - len(frame.data)) + 13) if frame.flags & ERROR else text


def _frame(
    stamp: bytes, channel: bytes, identifier: bytes, content: tuple[int, bytes, int] | str, direction: int
) -> Frame | str:
    if isinstance(content, str):
        return content
    can_id = int(identifier, 16)
    if len(identifier) == 8 and can_id < ERROR_BIT:
        kind = EXTENDED
    elif len(identifier) == 8 and can_id < 2 * ERROR_BIT:
        kind, can_id = ERROR, can_id & ~ERROR_BIT
    elif len(identifier) == 3 and can_id <= 0x7FF:
        kind = 0
    else:
        return f"{identifier.decode()} is not an identifier of 3 digits up to 7FF or of 8 up to 1FFFFFFF"
    length, data, remote = content
    return Frame(
        float(stamp), can_id, data, kind | remote | direction, length, channel.decode(errors="replace")
    )


def _in_digits(identifier: bytes) -> bytes:
    """Return an identifier with 3 digits, or with 8 where it has 29 bits."""
    return identifier.rjust(3 if len(identifier) < 8 and int(identifier, 16) <= 0x7FF else 8, b"0")


def _plain_content(length: bytes | None, tail: bytes) -> tuple[int, bytes, int] | str:
    """Return length, data and no flag of the bytes behind the identifier."""
    data = bytes.fromhex(tail.decode())
    if len(data) > 8:
        return "the data are not 0 to 8 bytes of two hexadecimal digits"
    if length is not None and len(data) != int(length):
        return f"the length says [{length.decode()}], the number of bytes is {len(data)}"
    return len(data), data, 0


def _content(tail: bytes) -> tuple[int, bytes, int] | str:
    """Return length, data and flags of what stands behind the `#`."""
    if match := _REMOTE_TAIL.fullmatch(tail):
        return int(match[1] or 0), b"", REMOTE
    if tail.startswith(b"#"):
        match = _FD_TAIL.fullmatch(tail)
        data = bytes.fromhex(match[2].replace(b".", b"").decode()) if match else b""
        if match is None or len(data) not in FD_LENGTHS:
            return "the data of a CAN FD frame are not 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes"
        return len(data), data, fd_flags(int(match[1], 16))
    match = _DATA_TAIL.fullmatch(tail)
    data = bytes.fromhex(match[1].replace(b".", b"").decode()) if match else b""
    if match is None or len(data) > 8:
        return "the data are not 0 to 8 bytes of two hexadecimal digits"
    return len(data), data, 0


def _long_content(length: bytes, tail: bytes) -> tuple[int, bytes, int] | str:
    """Return length, data and the REMOTE flag of what stands behind the identifier."""
    if len(length) == 4:
        return ONLY_CLASSICAL
    count = int(length[1:-1], 16) if length[:1] == b"[" else 8
    if b"remote" in tail:
        return (count, b"", REMOTE) if count <= 8 else "a remote request of more than 8 bytes"
    data = bytes.fromhex(tail.decode())
    if count > 8:
        return f"the length says [{count}]; a classical CAN frame has at most 8 bytes"
    if len(data) != count:
        return f"the length says [{count}], the number of bytes is {len(data)}"
    return count, data, 0
