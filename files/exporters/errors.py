"""Errors of the exporters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from pathlib import Path


class ExportError(OmnimateError):
    """Data that a format cannot hold, or a file that cannot be written.

    Attributes:
        target: The file or folder that was to be written.
    """

    def __init__(self, target: str | Path, problem: str) -> None:
        super().__init__(f"{target}: {problem}")
        self.target = str(target)


class MissingLibraryError(ExportError):
    """A format whose library is not installed.

    Attributes:
        extra: The extra that installs it.
    """

    def __init__(self, target: str | Path, library: str, extra: str) -> None:
        super().__init__(target, f"this format needs the library {library}: pip install 'omnimate[{extra}]'")
        self.extra = extra
