"""Logs written frame by frame in the formats of other tools, chosen by the suffix of the file."""

from __future__ import annotations

import contextlib
from functools import partial
from typing import TYPE_CHECKING, Protocol, cast

from omnimate.files.logs.formats.candump_writer import CandumpWriter
from omnimate.files.logs.formats.capture import PcapngWriter, PcapWriter
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.frames import ERROR, FD
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    import can

    from omnimate.files.logs.frames import Frame

SYNC_INTERVAL = 5.0  # [s] between two fsync calls; a lost file can be written again


class FrameWriter(Protocol):
    """A log that is being written."""

    def write_frame(self, frame: Frame) -> str | None:
        """Write a frame, or return why the format cannot hold it."""
        ...

    def close(self) -> None:
        """Write what is left, and close the file."""
        ...


@contextlib.contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Yield a temporary path that is renamed to `path` at the end; on an error it is removed.

    Raises:
        LogError: The file cannot be written.
    """
    temporary = path.with_name(f".{path.name}.part{path.suffix}")
    try:
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise LogError(path, None, f"cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def open_writer(path: Path, suffix: str) -> FrameWriter:
    """Return a writer of the format that a suffix of `SUFFIXES` names."""
    return _WRITERS[suffix](path)


def log_suffix(path: Path) -> str | None:
    """Return which of `SUFFIXES` the name of a file has; None for none of them."""
    return next((suffix for suffix in SUFFIXES if path.name.lower().endswith(suffix)), None)


class _PythonCan:
    """A format of python-can."""

    def __init__(self, path: Path) -> None:
        import can  # noqa: PLC0415 -- only who writes such a file needs python-can

        kinds = {".asc": can.ASCWriter, ".blf": can.BLFWriter, ".csv": can.CSVWriter}
        self._kind = path.suffix
        self._started: float | None = None
        self._file = cast("can.Listener", kinds[path.suffix](path))

    def write_frame(self, frame: Frame) -> str | None:
        is_fd = bool(frame.flags & FD)
        if is_fd and self._kind == ".csv":
            return "python-can's CSV holds no CAN FD frames"
        if is_fd and self._kind == ".asc" and not frame.data:
            return "in ASC a CAN FD frame without data would be read as a remote one"
        if is_fd and frame.flags & ERROR:
            return "an error frame of CAN FD"
        self._started = frame.time if self._started is None else self._started
        if self._kind != ".csv" and frame.time < self._started:
            return "it is earlier than the first frame, from which the file's times count"
        self._file.on_message_received(message_of_frame(frame))
        return None

    def close(self) -> None:
        self._file.stop()


_WRITERS: dict[str, Callable[[Path], FrameWriter]] = {
    ".log": partial(CandumpWriter, sync_interval=SYNC_INTERVAL),
    ".log.gz": partial(CandumpWriter, sync_interval=SYNC_INTERVAL),
    ".pcap": lambda path: PcapWriter(path.open("wb")),
    ".pcapng": lambda path: PcapngWriter(path.open("wb")),
    ".blf": _PythonCan,
    ".asc": _PythonCan,
    ".csv": _PythonCan,
}
SUFFIXES = tuple(_WRITERS)
