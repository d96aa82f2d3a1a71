"""Logs of other tools, read through python-can: Vector `.asc` and `.blf`, PEAK `.trc`, ASAM MF4, its own CSV.

The format is recognised by the content. python-can stops at the first bad line; here the line is reported and
reading continues after it.
"""

from __future__ import annotations

import io
import itertools
import re
from typing import TYPE_CHECKING, Literal

from omnimate.files.logs.formats.candump_blocks import SkippedLine
from omnimate.files.logs.formats.candump_lines import ONLY_CLASSICAL
from omnimate.files.logs.frames import BRS, DEFAULT_CHANNEL, ERROR, ESI, EXTENDED, FD, REMOTE, SENT, Frame

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    import can

    from omnimate.files.logs.formats.block_reader import BlockReader

LineFormat = Literal["asc", "csv", "trc"]
Format = Literal["asc", "blf", "csv", "mf4", "trc"]

_CHUNK = 2000  # lines that python-can reads at once

_TRC_EVENTS = {"Warng", "Error", "ST", "EC", "ER", "EV"}  # types of lines that are no frames
_ASC_META = re.compile(
    r"\s*(//|date |base |(no )?\s*internal|(begin|end)\s+trigger|\d+\.\d+\s+"
    r"(?!\d+\s+[0-9A-F]+x?\s|\d+\s+errorf|canfd))",
    re.IGNORECASE,
)
_CSV_HEAD = b"timestamp,arbitration_id,extended,remote,error,dlc,data"
_NUMBER = re.compile(r"\d+$")
_MAX_TIME = 2.0**32  # [s], in the year 2106
_MAX_CHANNEL = 0xFFFF  # that a BLF file can name


def format_of(head: bytes) -> Format | None:
    """Return the format that the first bytes of a file show; None for none of these."""
    if head.startswith(b"LOGG"):
        return "blf"
    if head.startswith(b"MDF     4"):
        return "mf4"
    text = head.lstrip(b"\xef\xbb\xbf \r\n\t")
    if text.startswith(b";"):
        return "trc"
    if text.startswith(_CSV_HEAD):
        return "csv"
    first = text[:40].lower()
    return "asc" if first.startswith((b"date ", b"base hex", b"base dec", b"// version")) else None


def frame_of_message(message: can.Message, *, fd: bool = False) -> Frame | str:
    """Return a python-can message as a frame, or the reason why it is none.

    Without `fd`, a CAN FD frame is none.
    """
    if message.is_fd and not fd:
        return ONLY_CLASSICAL
    kind = EXTENDED if message.is_extended_id else 0
    kind = ERROR if message.is_error_frame else kind
    if not 0 <= message.arbitration_id <= (0x7FF if kind == 0 else 0x1FFFFFFF):
        return f"{message.arbitration_id:X} is not an identifier of {11 if kind == 0 else 29} bits"
    if not 0.0 <= message.timestamp < _MAX_TIME:
        return f"{message.timestamp} is not a time in seconds"
    if message.is_fd:
        kind |= FD | message.bitrate_switch * BRS | message.error_state_indicator * ESI
    remote = REMOTE if message.is_remote_frame else 0
    data = b"" if remote else bytes(message.data or b"")
    length = message.dlc if remote else len(data)
    if length > (64 if message.is_fd else 8) or (length != message.dlc and not message.is_error_frame):
        return f"the length says {message.dlc}, the number of bytes is {len(data)}"
    return Frame(
        message.timestamp,
        message.arbitration_id,
        data,
        kind | remote | (0 if message.is_rx else SENT),
        length,
        _name(message.channel),
    )


def message_of_frame(frame: Frame) -> can.Message:
    """Return a frame as a python-can message; what the interface's name ends in is its number."""
    import can  # noqa: PLC0415 -- only who writes such a file needs python-can

    number = _NUMBER.search(frame.channel)
    remote = bool(frame.flags & REMOTE)
    return can.Message(
        timestamp=frame.time,
        arbitration_id=frame.can_id,
        is_extended_id=bool(frame.flags & EXTENDED),
        is_remote_frame=remote,
        is_error_frame=bool(frame.flags & ERROR),
        is_fd=bool(frame.flags & FD),
        bitrate_switch=bool(frame.flags & BRS),
        error_state_indicator=bool(frame.flags & ESI),
        is_rx=not frame.flags & SENT,
        channel=int(number[0]) if number and int(number[0]) < _MAX_CHANNEL else None,
        data=None if remote else frame.data,
        dlc=frame.length if remote else None,
    )


def read_binary(
    content: BlockReader, form: Literal["blf", "mf4"], *, fd: bool = True
) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of a Vector BLF file or of an ASAM MDF 4 file with bus logging, and what was left out.

    Without `fd`, CAN FD frames are left out.

    Raises:
        ImportError: asammdf is not installed, and the file is an MDF.
    """
    import can  # noqa: PLC0415 -- only who reads such a file needs python-can

    library = "python-can"
    if form == "mf4":
        import asammdf  # noqa: F401, PLC0415 -- an extra; python-can says it only later, and in other words

        library = "asammdf"
    number, size = 0, 0
    try:
        with can.MF4Reader(content.path) if form == "mf4" else can.BLFReader(content.file) as reader:
            size = reader.file_size if isinstance(reader, can.BLFReader) else 0
            for number, message in enumerate(reader, start=1):
                frame = frame_of_message(message, fd=fd)
                if isinstance(frame, str):
                    yield SkippedLine(number, str(message)[:80].rstrip(), frame)
                else:
                    yield frame
    except Exception as error:  # noqa: BLE001 -- both let any error of their parsing through
        yield SkippedLine(number + 1, "", f"{library} cannot read on: {error!r}", is_end=True)
        return
    if content.passed < size:
        yield SkippedLine(number + 1, "", "", is_end=True)


def read_lines(lines: Iterable[str], form: LineFormat, *, fd: bool = True) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of an `.asc`, `.csv` or `.trc` file, and the lines that were left out.

    Times of a `.trc` count from its start time, read as UTC; those of an `.asc` from the start of the log.

    Without `fd`, CAN FD frames are left out.
    """
    numbered: Iterator[tuple[int, str]] = enumerate(lines, start=1)
    head, first = "", None
    for number, line in numbered:
        if line.lstrip()[:1].isdigit():
            first = (number, line)
            break
        head += line
    if first is None:
        return
    numbered = itertools.chain([first], numbered)
    while chunk := list(itertools.islice(numbered, _CHUNK)):
        yield from _read_chunk(head, chunk, form, fd=fd)


def _read_chunk(
    head: str, chunk: list[tuple[int, str]], form: LineFormat, *, fd: bool
) -> Iterator[Frame | SkippedLine]:
    """Read lines at once where all is well, else one by one to see which of them are bad."""
    rows = _messages(head, [line for _, line in chunk], form, fd=fd)
    if isinstance(rows, list) and len(rows) == sum(not _IS_NO_FRAME[form](line) for _, line in chunk):
        yield from rows
        return
    for number, line in chunk:
        if not _IS_NO_FRAME[form](line):
            result = _messages(head, [line], form, fd=fd)
            row = result if isinstance(result, str) else next(iter(result), "python-can finds no frame in it")
            is_end = not line.endswith("\n")
            yield SkippedLine(number, line[:80].rstrip(), row, is_end) if isinstance(row, str) else row


def _messages(head: str, lines: list[str], form: LineFormat, *, fd: bool) -> list[Frame] | str:
    """Return the frames of lines under their file's head, or why one of them is none."""
    import can  # noqa: PLC0415 -- only who reads such a file needs python-can

    readers = {"asc": can.ASCReader, "csv": can.CSVReader, "trc": can.TRCReader}
    file = io.StringIO(head + "".join(lines))
    frames: list[Frame] = []
    try:
        for message in readers[form](file):
            frame = frame_of_message(message, fd=fd)
            if isinstance(frame, str):
                return frame
            frames.append(frame)
    except Exception as error:  # noqa: BLE001 -- python-can lets any error of its parsing through
        return f"python-can cannot read it: {error!r}"
    return frames


def _is_no_trc_frame(line: str) -> bool:
    """Say whether a line is a comment or an event, which PEAK's tools write between the frames."""
    return not line.strip() or line.lstrip().startswith(";") or bool(_TRC_EVENTS & set(line.split()[1:4]))


def _is_no_asc_frame(line: str) -> bool:
    """Say whether a line is one of the comments, triggers and events of Vector's tools."""
    return not line.strip() or _ASC_META.match(line) is not None


_IS_NO_FRAME = {"asc": _is_no_asc_frame, "csv": lambda line: not line.strip(), "trc": _is_no_trc_frame}


def _name(channel: object) -> str:
    if isinstance(channel, int):
        return f"can{channel}"
    return "_".join(str(channel).split()) if channel else DEFAULT_CHANNEL
