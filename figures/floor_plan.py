"""The floor plan of a drive: the driven path and the path by odometry."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING

from omnimate.figures.files import drawn
from omnimate.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.vehicle.se2 import Array

_TRACKS = (GREY, BLUE, VERMILLION, GREEN, PURPLE, ORANGE)


@dataclass(frozen=True, slots=True)
class Track:
    """One line of a floor plan.

    The path has x and y first [m], shape `(N, 2)` or `(N, 3)`; calculated paths next to the driven one are
    dashed.
    """

    label: str
    path: Array
    dashed: bool = False


def plot_floor_plan(
    tracks: Sequence[Track], path: Path, *, title: str = "", fixes: Array | None = None
) -> None:
    """Draw paths over the floor [m], the driven one and those by odometry.

    The first track is grey and wide, as the reference for the others; `fixes` are absolute poses, x and y
    first [m], shape `(M, 2)` or `(M, 3)`.

    Raises:
        PlotError: The file cannot be written.
    """
    with drawn(path, 6.4, 6.6) as (figure, axes):
        for number, (track, color) in enumerate(zip(tracks, cycle(_TRACKS), strict=False)):
            width, line = (3.2 if number == 0 else 1.3), ("--" if track.dashed else "-")
            alpha = 0.55 if number == 0 else 1.0
            x, y = track.path[:, 0], track.path[:, 1]
            axes.plot(x, y, line, color=color, linewidth=width, alpha=alpha, label=track.label)
            axes.plot(x[-1:], y[-1:], "o", color=color, markersize=6, markeredgecolor="white", zorder=4)
        if fixes is not None:
            label = "absolute fix"
            axes.plot(
                fixes[:, 0], fixes[:, 1], "k+", markersize=9, markeredgewidth=1.4, label=label, zorder=5
            )
        axes.set(xlabel="x [m]", ylabel="y [m]", title=title)
        axes.set_aspect("equal", adjustable="datalim")
        figure.legend(loc="outside lower center", ncols=2)
