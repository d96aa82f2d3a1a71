"""The floor of a hall with its bad places, and the history of a robot's number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Circle, Ellipse

from omnimate.figures.files import drawn
from omnimate.figures.style import BLUE, GREY, VERMILLION

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.vehicle.se2 import Array

_TWO_SIGMA = 2.448  # of an ellipse that holds a place with 95 %: the square root of chi-square's, 2 degrees
_COLORS = {"loss": VERMILLION, "creep": BLUE}
_WORDS = {"loss": "travel is lost", "creep": "robots creep"}


@dataclass(frozen=True, slots=True)
class MapPlace:
    """A bad place on a map.

    The effect is "loss" or "creep"; x, y and the radius `reach` are in m, the covariance of x and y is `(2,
    2)` [m^2]; `creep` is its direction, `(2,)`, None for a loss.
    """

    effect: str
    x: float
    y: float
    reach: float
    covariance: Array
    label: str
    creep: Array | None = None


def plot_floor_map(places: Sequence[MapPlace], driven: Array, path: Path, *, title: str = "") -> None:
    """Draw the floor [m]: where robots drove, and its bad places with the ellipse that holds each with 95 %.

    `driven` are the cells that were driven over: x and y [m] and how often, `(N, 3)`.

    Raises:
        PlotError: The file cannot be written.
    """
    with drawn(path, 8.0, 6.4) as (figure, axes):
        axes.scatter(
            driven[:, 0], driven[:, 1], c=np.sqrt(driven[:, 2]), s=5.0, cmap="Greys", marker="s", linewidths=0
        )
        shown: set[str] = set()
        for place in places:
            color = _COLORS[place.effect]
            label = None if place.effect in shown else _WORDS[place.effect]
            shown.add(place.effect)
            at = place.x, place.y
            axes.add_patch(Circle(at, place.reach, color=color, alpha=0.45, linewidth=0, label=label))
            widths, axis = np.linalg.eigh(place.covariance)
            sizes = 2.0 * _TWO_SIGMA * np.sqrt(np.maximum(widths, 0.0))
            angle = float(np.degrees(np.arctan2(axis[1, 0], axis[0, 0])))
            axes.add_patch(
                Ellipse(at, float(sizes[0]), float(sizes[1]), angle=angle, fill=False, color=color)
            )
            if place.creep is not None:
                tip = 1.5 * place.creep / np.hypot(*place.creep)
                axes.annotate(
                    "",
                    (place.x + tip[0], place.y + tip[1]),
                    at,
                    arrowprops={"arrowstyle": "->", "color": color},
                )
            axes.annotate(place.label, at, xytext=(8, 8), textcoords="offset points", fontsize=8, color=color)
        axes.set(xlabel="x [m]", ylabel="y [m]", title=title)
        axes.set_aspect("equal", adjustable="datalim")
        if places:
            figure.legend(loc="outside lower center", ncols=3)


def plot_history(
    days: Array,
    value: Array,
    sigma: Array,
    path: Path,
    *,
    since: float | None,
    label: str,
    title: str = "",
) -> None:
    """Draw a robot's number day by day, with its 95 % intervals, and the day since which it changes.

    `days` since the first one, `value` and `sigma` are `(D,)`; `since` is the day of the change, None for
    none.

    Raises:
        PlotError: The file cannot be written.
    """
    with drawn(path, 6.4, 3.6) as (_, axes):
        axes.errorbar(days, value, 1.96 * sigma, fmt="o", color=BLUE, ecolor=GREY, markersize=4)
        if since is not None:
            axes.axvline(since - 0.5, color=VERMILLION, linestyle="--")
        axes.set(xlabel="day", ylabel=label, title=title)
