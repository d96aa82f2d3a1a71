"""The real part of the study: tables and figures of what the tool finds in recordings of real robots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.table import Table

from studies.mismatch.real_figures import draw_husky, draw_labyrinth
from studies.mismatch.real_rows import robot_row

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from omnimate.mismatch import Diagnosis

DATA = ("labyrinth_tuc", "drive_ugv")  # the folders of the data
HUSKY_EVERY = 6  # one in so many windows is searched; the first look sees all


def real_part(folder: Path, figures: Path | None) -> Iterator[Table | str]:
    """Yield what the tool finds in the real recordings that are there, and draw it where a folder is given.

    Raises:
        SourceError: The data are damaged.
        PlotError: A figure cannot be written.
    """
    for name in DATA:
        if not (folder / name).is_dir():
            yield f"{folder / name} is not there: left out"
        else:
            yield from _robot(folder / name, figures)


def _robot(folder: Path, figures: Path | None) -> Iterator[Table | str]:
    is_husky = folder.name == "drive_ugv"
    row = robot_row(folder, HUSKY_EVERY if is_husky else 1)
    table = Table(title=f"{row.name}: as described, and as the first look corrects it")
    for heading in ("robot", "held-out residual", "findings"):
        table.add_column(heading)
    table.add_row("as described", residual(row.first), findings(row.first, 5))
    table.add_row("corrected", residual(row.second), findings(row.second, 5))
    yield table
    yield row.first.says
    if figures is not None:
        (draw_husky if is_husky else draw_labyrinth)(row, figures)


def residual(diagnosis: Diagnosis) -> str:
    """Return the held-out residual without and with what was found."""
    fit = diagnosis.fit
    return "-" if fit is None else f"{fit.heldout.before:.2f} -> {fit.heldout.after:.2f}"


def findings(diagnosis: Diagnosis, most: int = 3) -> str:
    """Return the first findings with their probabilities, and what an unknown depends on."""
    shown = [
        f"{finding.effect} {finding.component} {finding.probability:.0%}"
        + (f" ({finding.where.regime})" if finding.effect == "unknown" else "")
        for finding in diagnosis.findings[:most]
    ]
    return "; ".join(shown) or diagnosis.verdict
