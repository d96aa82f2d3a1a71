"""Figures as files: the formats, and how a figure is written."""

from __future__ import annotations

import io
from contextlib import contextmanager
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure

from omnimate.figures.style import STYLE
from omnimate.vehicle.atomic import write_bytes
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from matplotlib.axes import Axes

FORMATS = (".png", ".svg", ".pdf")


class PlotError(OmnimateError):
    """A figure that cannot be written.

    Attributes:
        path: Path of the file.
    """

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path


def check_format(path: Path) -> None:
    """Refuse a file name without a known format of pictures, or in a missing folder.

    Raises:
        PlotError: The format is unknown, or the folder is missing.
    """
    if path.suffix.lower() not in FORMATS:
        raise PlotError(path, f"unknown format {path.suffix!r}; expected a name with {', '.join(FORMATS)}")
    if not path.absolute().parent.is_dir():
        raise PlotError(path, "its folder is not there; create it first")


@contextmanager
def drawn(path: Path, width: float, height: float) -> Iterator[tuple[Figure, Axes]]:
    """Give a new figure of one panel and its axes, and write it in the end; the size is in inches.

    Raises:
        PlotError: The file cannot be written.
    """
    check_format(path)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        yield figure, figure.subplots()
        save(figure, path)


def save(figure: Figure, path: Path) -> None:
    """Write a figure whole or not at all.

    Raises:
        PlotError: The file cannot be written.
    """
    try:
        write_bytes(path, rendered(figure, path.suffix.lower().removeprefix(".")))
    except OSError as error:
        raise PlotError(path, f"cannot be written: {error.strerror or error}") from error


def rendered(figure: Figure, kind: str) -> bytes:
    """Return a figure as a png, svg or pdf: the same bytes for the same content."""
    buffer = io.BytesIO()
    stamp = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    with mpl.rc_context(STYLE):
        figure.savefig(buffer, format=kind, dpi=160, metadata=stamp)
    return buffer.getvalue()
