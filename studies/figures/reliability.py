"""Reliability diagrams: what was said against how often it was right, a panel for each world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREY, STYLE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

_COLUMNS = 4


class Bin(Protocol):
    """Findings of about the same probability."""

    @property
    def said(self) -> float:
        """Mean of their probabilities."""
        ...

    @property
    def of(self) -> int:
        """Number of the findings."""
        ...

    @property
    def share(self) -> float:
        """Share of those that are right."""
        ...

    @property
    def interval(self) -> tuple[float, float]:
        """Its 95 % interval."""
        ...


def plot_reliability(panels: Mapping[str, Sequence[Bin]], path: Path) -> None:
    """Draw a reliability diagram for each world; a tool that is as sure as it is right lies on the diagonal.

    Args:
        panels: The findings about each world in bins of their probability, by the world's title.
        path: Path of the file; its suffix gives the format.

    Raises:
        PlotError: The file cannot be written.
    """
    check_format(path)
    columns = min(_COLUMNS, len(panels))
    count = -(-len(panels) // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.6 * columns + 0.5, 2.7 * count + 0.4), layout="constrained")
        grid = figure.subplots(count, columns, sharex=True, sharey=True, squeeze=False)
        for axes, (title, bins) in zip(grid.flat, panels.items(), strict=False):
            axes.plot([0.0, 1.0], [0.0, 1.0], "--", color=GREY, linewidth=1.0)
            said, share = np.array([each.said for each in bins]), np.array([each.share for each in bins])
            ends = np.array([each.interval for each in bins]).reshape(-1, 2)
            reach = np.abs(ends.T - share)
            axes.errorbar(said, share, reach, fmt="o-", color=BLUE, markersize=4, linewidth=1.0, capsize=2)
            for each in bins:
                axes.annotate(
                    str(each.of),
                    (each.said, each.share),
                    (4, -9 if each.share > 0.5 else 4),
                    textcoords="offset points",
                    fontsize=7,
                )
            axes.set(title=title, xlim=(-0.03, 1.03), ylim=(-0.03, 1.03), aspect="equal")
            axes.set_xticks([0.0, 0.5, 1.0])
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        figure.supxlabel("probability that was said", fontsize=10)
        figure.supylabel("share that is right, 95 % interval", fontsize=10)
        save(figure, path)
