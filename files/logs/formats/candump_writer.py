"""Writing of bus logs in real time; a crash or a power cut loses one second at most."""

from __future__ import annotations

import contextlib
import gzip
import os
import threading
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Self, cast

from omnimate.files.logs.formats.candump_lines import format_frame

if TYPE_CHECKING:
    from types import TracebackType

    from omnimate.files.logs.frames import Frame

SYNC_INTERVAL = 0.5  # [s] between two fsync calls


class CandumpWriter:
    """Writes frames as `candump -L` prints them.

    A thread of its own puts what was written on disk every `sync_interval`, also while the bus is silent;
    the end of the process or of the machine loses that much at most. Where the disk refuses, frames are left
    out until it takes again what was written before; a compressed log ends there.

    Attributes:
        path: Path of the file.
    """

    def __init__(self, path: Path | str, *, sync_interval: float = SYNC_INTERVAL) -> None:
        """Start a new file, replacing an older one.

        A name with `.gz` is compressed; `sync_interval` is the wall-clock time between two requests to the
        disk [s].

        Raises:
            OSError: The file cannot be opened.
        """
        self.path = Path(path)
        self._disk = self.path.open("wb")
        self._file: BinaryIO = self._disk
        if self.path.suffix == ".gz":
            self._file = cast("BinaryIO", gzip.GzipFile("", "wb", fileobj=self._disk))
        self._lock = threading.Lock()
        self._refusal: OSError | None = None
        self._closing = threading.Event()
        self._syncer = threading.Thread(target=self._sync_regularly, args=(sync_interval,), daemon=True)
        self._syncer.start()

    def write_frame(self, frame: Frame) -> None:
        """Write one frame.

        Raises:
            OSError: The disk refuses, as one that is full; the frame is left out.
        """
        line = format_frame(frame).encode() + b"\n"
        with self._lock:
            if self._refusal is not None:
                raise OSError(*self._refusal.args)
            try:
                self._file.write(line)
            except OSError as error:
                self._refusal = error
                raise

    def sync(self) -> None:
        """Put on disk what was written so far.

        Raises:
            OSError: The disk refuses; frames are left out until a later call succeeds.
        """
        try:
            with self._lock:
                if self._disk.closed:
                    return
                self._file.flush()
                self._disk.flush()
                handle = os.dup(self._disk.fileno())
            try:
                os.fsync(handle)  # may take long, and nothing waits for it
            finally:
                os.close(handle)
        except OSError as error:
            self._refusal = error
            raise
        self._refusal = None

    def close(self) -> None:
        """Put everything on disk and close the file; a second call does nothing.

        Raises:
            OSError: The disk refuses the last frames; the file is closed all the same.
        """
        self._closing.set()
        if self._syncer is not threading.current_thread():
            self._syncer.join()
        try:
            self.sync()
        finally:
            with self._lock, contextlib.ExitStack() as files:
                files.callback(self._disk.close)
                files.callback(self._file.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _sync_regularly(self, interval: float) -> None:
        while not self._closing.wait(interval):
            with contextlib.suppress(OSError):  # `write_frame` raises it
                self.sync()
