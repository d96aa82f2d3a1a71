"""Atomic writing of files."""

from __future__ import annotations

import os
import uuid
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def write_text(path: Path, text: str) -> None:
    """Replace the content of a file atomically: after a crash it is either the old or the new one.

    A link keeps pointing to the file, which keeps its permissions. What is no file, such as a pipe or a
    device, is written as it is.

    Raises:
        OSError: It cannot be written; `filename` is `path`.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """Replace the content of `path` atomically, as `write_text`."""
    try:
        if path.exists() and not path.is_file():
            path.write_bytes(content)  # the link /dev/fd/N of a pipe resolves to no path
        else:
            _replace(path.resolve(), content)
    except OSError as error:
        if error.errno is not None:  # the file that was asked for, and not the temporary one
            error.filename = str(path)
        raise


def _replace(path: Path, content: bytes) -> None:
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}")
    try:
        with temporary.open("xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        if path.exists():
            temporary.chmod(path.stat().st_mode & 0o777)
        temporary.replace(path)
        _sync(path.parent)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def make_folder(path: Path) -> None:
    """Make a folder and its parents, and flush their directory entries to disk."""
    if not path.is_dir():
        make_folder(path.parent)
        path.mkdir(exist_ok=True)
        _sync(path.parent)


def _sync(folder: Path) -> None:
    """Flush a folder's directory entries to disk; Windows has no such call."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
