"""The root of every error that this project raises on purpose, and the errors of this room."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

UTF_16_MARKS = BOM_UTF16_LE, BOM_UTF16_BE  # with one of which editors on Windows begin a file
IS_UTF_16 = "it is UTF-16; save the file as UTF-8"


class OmnimateError(Exception):
    """An error that a user can correct; its text says what was expected, where, and what to do."""


class TableError(OmnimateError):
    """A table of a file with an unknown key, or with a value that is missing or impossible.

    `key` is dotted, as in `truck.a.wheelbase`; `problem` says what is wrong and what was expected.
    """

    def __init__(self, key: str, problem: str) -> None:
        super().__init__(f"{key}: {problem}")
        self.key = key
        self.problem = problem


class InputError(OmnimateError):
    """An error of one file, folder, recording, robot or option, the `source`, which the text names first."""

    def __init__(self, source: str | Path, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = str(source)


class VehicleFileError(InputError):
    """A `vehicle.toml`, `source`, that does not describe a possible robot; `key` is as in `TableError`."""

    def __init__(self, source: str | Path, key: str, problem: str) -> None:
        super().__init__(source, f"{key}: {problem}")
        self.key = key


class LogError(OmnimateError):
    """A bus log, `source`, that cannot be read, or not to its end.

    `line` is the first bad one, counted from 1; None where the format has no lines.
    """

    def __init__(self, source: str | Path, line: int | None, problem: str) -> None:
        where = f"{source}:{line}" if line is not None else f"{source}"
        super().__init__(f"{where}: {problem}")
        self.source = str(source)
        self.line = line


class RecordingError(InputError):
    """A recording folder, or a file in it, `source`, that is incomplete or contradicts itself."""


def describe_read_error(error: OSError | UnicodeDecodeError) -> str:
    """Return why a text file cannot be read, and what to do where it is no UTF-8."""
    if isinstance(error, UnicodeDecodeError):
        if error.object.startswith(UTF_16_MARKS):
            return IS_UTF_16
        return f"byte {error.start + 1} is not UTF-8; save the file as UTF-8"
    return error.strerror or str(error)
