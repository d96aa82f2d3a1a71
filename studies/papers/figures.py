"""The papers' figures, drawn from simulated drives: U 6 and 11, C 8 and 10, O 5-8, and C's growth rates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.figures.clusters import Clusters, plot_clusters
from omnimate.figures.files import PlotError
from studies.papers.clapper_figures import draw_c8, draw_c10
from studies.papers.figure_parts import ROBOT
from studies.papers.growth_figure import draw_growth
from studies.papers.lap_figures import draw_headings, draw_positions
from studies.papers.squares import FIGURE_11, stages_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


def draw_all(folder: Path) -> Iterator[Path]:
    """Draw all figures into a folder, which is made if need be; yield each file's path when it is written.

    Raises:
        PlotError: the folder or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(folder, f"cannot be made: {error.strerror}") from error
    figures: dict[str, Callable[[Path], None]] = {
        "u06-return-positions": draw_u6,
        "u11-before-and-after": draw_u11,
        "c08-straight-line": draw_c8,
        "c10-rectangle": draw_c10,
        "o05-positions-no-bumps": lambda path: draw_positions(path, 5, slice(0, 5)),
        "o06-headings-no-bumps": lambda path: draw_headings(path, 6, slice(0, 5)),
        "o07-positions-bumps": lambda path: draw_positions(path, 7, slice(5, 10)),
        "o08-headings-bumps": lambda path: draw_headings(path, 8, slice(5, 10)),
        "growth-rates": draw_growth,
    }
    for name, draw in figures.items():
        path = folder / f"{name}.png"
        draw(path)
        yield path


def draw_u6(path: Path) -> None:
    """Draw U Fig. 6: where the uncalibrated robot returns to, and the centres of gravity."""
    before, *_ = stages_of(FIGURE_11, ROBOT)
    plot_clusters([Clusters("U Fig. 6, simulated: 4 x 4 m square, uncalibrated", before)], path)


def draw_u11(path: Path) -> None:
    """Draw U Fig. 11: the same before and after the calibration."""
    before, after, _ = stages_of(FIGURE_11, ROBOT)
    plot_clusters([Clusters("U Fig. 11, simulated: UMBmark, one pass", before, after)], path)
