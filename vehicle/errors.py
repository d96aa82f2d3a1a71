"""The root of every error that this project raises on purpose, and the errors of this room."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


class OmnimateError(Exception):
    """An error that a user can correct; its text says what was expected, where, and what to do."""


class TableError(OmnimateError):
    """A table of a file with an unknown key, or with a value that is missing or impossible.

    Attributes:
        key: Dotted key inside the file or the table, such as `truck.a.wheelbase`.
        problem: What is wrong with it and what was expected.
    """

    def __init__(self, key: str, problem: str) -> None:
        super().__init__(f"{key}: {problem}")
        self.key = key
        self.problem = problem


class VehicleFileError(OmnimateError):
    """A `vehicle.toml` that does not describe a possible robot.

    Attributes:
        source: Name of the file.
        key: Dotted key inside the file, such as `truck.a.wheelbase`.
    """

    def __init__(self, source: str | Path, key: str, problem: str) -> None:
        super().__init__(f"{source}: {key}: {problem}")
        self.source = str(source)
        self.key = key


class LogError(OmnimateError):
    """A bus log that cannot be read, or not to its end.

    Attributes:
        source: Name of the file.
        line: First bad line of the file, counted from 1; None where the format has no lines.
    """

    def __init__(self, source: str | Path, line: int | None, problem: str) -> None:
        where = f"{source}:{line}" if line is not None else f"{source}"
        super().__init__(f"{where}: {problem}")
        self.source = str(source)
        self.line = line


class RecordingError(OmnimateError):
    """A recording folder that is incomplete or contradicts itself.

    Attributes:
        source: Name of the folder, or of the file in it.
    """

    def __init__(self, source: str | Path, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = str(source)


def describe_read_error(error: OSError | UnicodeDecodeError) -> str:
    """Return why a text file cannot be read, and what to do where it is no UTF-8."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start + 1} is not UTF-8; save the file as UTF-8"
    return error.strerror or str(error)
