"""Parts that several of the papers' figures share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.figures.style import GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from omnimate.vehicle.se2 import Array

ROBOT = 0  # the papers show a single robot; this is the first of the table


def draw_dots(
    axes: Axes, points: Array, color: str, marker: str, *, filled: bool, label: str | None = None
) -> None:
    """Draw points `(N, 2)` as filled or open marks."""
    face = color if filled else "white"
    x, y = points[:, 0], points[:, 1]
    axes.scatter(
        x, y, s=42, marker=marker, facecolors=face, edgecolors=color, linewidths=1.2, label=label, zorder=3
    )


def draw_cross(axes: Axes) -> None:
    """Draw the axes through the origin."""
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.axvline(0.0, color=GREY, linewidth=0.8)
