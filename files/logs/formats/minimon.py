"""Traces of IXXAT MiniMon: CSV in which every field stands in quotes, times count from the start."""

from __future__ import annotations

import re
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from omnimate.files.logs.formats.candump_blocks import SkippedLine
from omnimate.files.logs.frames import EXTENDED, REMOTE, Frame

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

SIGNATURE = b"ASCII Trace IXXAT MiniMon"

_ROW = re.compile(
    r'"(\d\d):(\d\d):(\d\d\.\d+)";"([0-9A-F]{1,8})";"(Std|Ext)";"([^"]*)";"([^"]*)"\s*', re.IGNORECASE
)
_LENGTH = re.compile(r"DLC = ([0-8])")
_START = {"Date: ": "%d.%m.%Y", "Start time: ": "%H:%M:%S"}


def read_trace(lines: Iterable[str]) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of a trace, and the lines that hold none with the reason."""
    numbered = enumerate(lines, start=1)
    head = []
    for _, line in numbered:
        head.append(line)
        if line.startswith('"Time"'):
            break
    start = _start_time(head)
    for number, line in numbered:
        frame = _parse_row(line, start) if line.strip() else None
        if isinstance(frame, str):
            yield SkippedLine(number, line.removesuffix("\n")[:80], frame, is_end=not line.endswith("\n"))
        elif frame is not None:
            yield frame


def _start_time(head: Iterable[str]) -> float:
    """Return the time [s] at which a trace starts by its own header, read as UTC; 0 where it does not say."""
    entries = {key: line.removeprefix(key).strip() for line in head for key in _START if line.startswith(key)}
    if entries.keys() != _START.keys():
        return 0.0
    try:
        start = datetime.strptime(" ".join(entries[key] for key in _START), " ".join(_START.values()))  # noqa: DTZ007 -- the zone is set below
    except ValueError:
        return 0.0
    return start.replace(tzinfo=UTC).timestamp()


def _parse_row(line: str, start: float) -> Frame | str:
    """Return the frame of a row, or the reason why it holds none."""
    match = _ROW.fullmatch(line)
    if match is None:
        return 'expected `"hh:mm:ss.cc";"ID";"Std";"flags";"data"`'
    hours, minutes, seconds, identifier, kind, flags, data = match.groups()
    time = start + 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    extended = EXTENDED if kind.lower() == "ext" else 0
    can_id = int(identifier, 16)
    if can_id > (0x1FFFFFFF if extended else 0x7FF):
        return f"{identifier} is not an identifier of {29 if extended else 11} bits"
    if "rtr" in flags.lower():
        length = _LENGTH.search(data)
        return Frame(time, can_id, b"", extended | REMOTE, int(length[1]) if length else 0)
    try:
        content = bytes.fromhex(data)
    except ValueError:
        return "the data are not bytes of two hexadecimal digits"
    return Frame(time, can_id, content, extended) if len(content) <= 8 else "more than 8 bytes of data"
