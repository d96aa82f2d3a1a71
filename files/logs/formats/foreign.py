"""Reading of logs of other formats than candump, entry by entry in bounded memory."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Literal

from omnimate.files.logs.formats import minimon
from omnimate.files.logs.formats.candump_blocks import SkippedLine
from omnimate.files.logs.formats.capture import CaptureFormat, capture_format_of, read_capture
from omnimate.files.logs.formats.python_can_logs import (
    Format,
    format_of,
    read_binary,
    read_lines,
)
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.logs.formats.block_reader import BlockReader
    from omnimate.files.logs.frames import Frame

ForeignFormat = Format | CaptureFormat | Literal["minimon"]


def foreign_format_of(head: bytes) -> ForeignFormat | None:
    """Return the format that the first bytes of a log show; None for candump."""
    if head.startswith(minimon.SIGNATURE):
        return "minimon"
    return format_of(head) or capture_format_of(head)


def read_entries(
    content: BlockReader, form: ForeignFormat, *, fd: bool = True
) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of a log in their order, and what was left out of it.

    Without `fd`, CAN FD frames are left out.

    Raises:
        LogError: What the format needs is not installed.
    """
    if form == "blf" or form == "mf4":  # noqa: PLR1714 -- so that the type of the rest is known
        try:
            yield from read_binary(content, form, fd=fd)
        except ImportError as error:
            needed = "an MF4 file needs the library asammdf: pip install 'omnimate[mf4]'"
            raise LogError(content.path, None, needed) from error
    elif form == "pcap" or form == "pcapng":  # noqa: PLR1714 -- likewise
        yield from read_capture(content.file, fd=fd)
    elif form == "minimon":
        yield from minimon.read_trace(_text(content))
    else:
        yield from read_lines(_text(content), form, fd=fd)
    if content.damaged:
        yield SkippedLine(0, "", "", is_end=True)


def _text(content: BlockReader) -> io.TextIOWrapper:
    return io.TextIOWrapper(content.file, "utf-8-sig", errors="replace")
