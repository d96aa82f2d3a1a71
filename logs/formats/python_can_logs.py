"""Logs of other tools, read through python-can: Vector `.asc` and `.blf`, PEAK `.trc`.

The format is recognised by the content. python-can stops at the first bad line; here the line is noted
and reading goes on behind it.
"""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Literal

from omnimate.logs.formats.candump_blocks import SkippedLine
from omnimate.logs.frames import DEFAULT_CHANNEL, ERROR, EXTENDED, REMOTE, Frame

if TYPE_CHECKING:
    import can

LineFormat = Literal["asc", "trc"]
Format = Literal["asc", "blf", "trc"]

_CHUNK = 2000  # lines that python-can reads at once

_TRC_EVENTS = {"Warng", "Error", "ST", "EC", "ER", "EV"}  # types of lines that are no frames
_ASC_META = re.compile(
    r"\s*(//|date |base |(no )?\s*internal|(begin|end)\s+trigger|\d+\.\d+\s+"
    r"(?!\d+\s+[0-9A-F]+x?\s|\d+\s+errorf|canfd))",
    re.IGNORECASE,
)


def format_of(head: bytes) -> Format | None:
    """Return the format that the first bytes of a file show; None for none of these."""
    if head.startswith(b"LOGG"):
        return "blf"
    text = head.lstrip(b"\xef\xbb\xbf \r\n\t")
    if text.startswith(b";"):
        return "trc"
    first = text[:40].lower()
    return "asc" if first.startswith((b"date ", b"base hex", b"base dec", b"// version")) else None


def frame_of_message(message: can.Message) -> Frame | str:
    """Return a python-can message as a frame, or the reason why it is none of classical CAN."""
    if message.is_fd:
        return "a CAN FD frame; only classical CAN is read"
    kind = EXTENDED if message.is_extended_id else 0
    kind = ERROR if message.is_error_frame else kind
    if not 0 <= message.arbitration_id <= (0x7FF if kind == 0 else 0x1FFFFFFF):
        return f"{message.arbitration_id:X} is not an identifier of {11 if kind == 0 else 29} bits"
    remote = REMOTE if message.is_remote_frame else 0
    data = b"" if remote else bytes(message.data or b"")
    length = message.dlc if remote else len(data)
    if length > 8 or (length != message.dlc and not message.is_error_frame):
        return f"the length says {message.dlc}, the number of bytes is {len(data)}"
    return Frame(
        message.timestamp,
        message.arbitration_id,
        data,
        kind | remote,
        length,
        _name(message.channel),
    )


def read_blf(content: bytes) -> tuple[list[Frame], list[SkippedLine], bool]:
    """Return the frames of a Vector BLF file, what was left out, and whether it ends early."""
    import can  # noqa: PLC0415 -- only who reads such a file needs python-can

    frames: list[Frame] = []
    skipped: list[SkippedLine] = []
    try:
        reader = can.BLFReader(io.BytesIO(content))
        for number, message in enumerate(reader, start=1):
            _take(frame_of_message(message), number, str(message), frames, skipped)
    except Exception as error:  # noqa: BLE001 -- python-can lets any error of its parsing through
        skipped.append(SkippedLine(len(frames) + 1, "", f"python-can cannot read on: {error!r}"))
        return frames, skipped, True
    return frames, skipped, len(content) < reader.file_size


def read_lines(content: str, form: LineFormat) -> tuple[list[Frame], list[SkippedLine]]:
    """Return the frames of an `.asc` or `.trc` file and the lines that were left out.

    Times of a `.trc` count from its start time, read as UTC; those of an `.asc` from the start of the log.
    """
    lines = content.splitlines(keepends=True)
    first = next((number for number, line in enumerate(lines) if line.lstrip()[:1].isdigit()), len(lines))
    head = "".join(lines[:first])
    frames: list[Frame] = []
    skipped: list[SkippedLine] = []
    for start in range(first, len(lines), _CHUNK):
        _read_chunk(head, lines[start : start + _CHUNK], start + 1, form, frames, skipped)
    return frames, skipped


def _read_chunk(
    head: str,
    lines: list[str],
    number: int,
    form: LineFormat,
    frames: list[Frame],
    skipped: list[SkippedLine],
) -> None:
    """Read lines at once where all is well, else one by one to see which of them are bad."""
    rows = _messages(head, lines, form)
    if isinstance(rows, list) and len(rows) == sum(not _IS_NO_FRAME[form](line) for line in lines):
        frames.extend(rows)
        return
    for offset, line in enumerate(lines):
        if not _IS_NO_FRAME[form](line):
            result = _messages(head, [line], form)
            row = result if isinstance(result, str) else next(iter(result), "python-can finds no frame in it")
            _take(row, number + offset, line, frames, skipped)


def _messages(head: str, lines: list[str], form: LineFormat) -> list[Frame] | str:
    """Return the frames of lines under their file's head, or why one of them is none."""
    import can  # noqa: PLC0415 -- only who reads such a file needs python-can

    file = io.StringIO(head + "".join(lines))
    frames: list[Frame] = []
    try:
        for message in can.ASCReader(file) if form == "asc" else can.TRCReader(file):
            frame = frame_of_message(message)
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


_IS_NO_FRAME = {"asc": _is_no_asc_frame, "trc": _is_no_trc_frame}


def _take(
    frame: Frame | str, number: int, text: str, frames: list[Frame], skipped: list[SkippedLine]
) -> None:
    if isinstance(frame, str):
        skipped.append(SkippedLine(number, text[:80].rstrip(), frame))
    else:
        frames.append(frame)


def _name(channel: object) -> str:
    if isinstance(channel, int):
        return f"can{channel}"
    return "_".join(str(channel).split()) if channel else DEFAULT_CHANNEL
