"""The figures of C 6: the straight line and the rectangle, with and without IPEC."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import save
from omnimate.figures.style import BLUE, GREEN, GREY, STYLE, VERMILLION
from studies.papers.estimates import sizes
from studies.papers.figure_parts import ROBOT, draw_cross, draw_dots
from studies.papers.protocols import rectangle_errors, straight_errors

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from omnimate.vehicle.se2 import Array


def draw_c8(path: Path) -> None:
    """Draw C Fig. 8: return positions and headings of 18 m out and back, 3 runs of each condition."""
    smooth, bumpy = straight_errors(ROBOT, 0), straight_errors(ROBOT, 10)
    series = (
        ("without IPEC, no bumps", smooth["plain"], GREY, "o", False),
        ("without IPEC, 10 bumps under each truck", bumpy["plain"], VERMILLION, "s", False),
        ("with IPEC, no bumps", smooth["CLAPPER"], GREEN, "o", True),
        ("with IPEC, 10 bumps under each truck", bumpy["CLAPPER"], BLUE, "s", True),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.0, 5.4), layout="constrained")
        figure.suptitle("C Fig. 8, simulated: 18 m straight out and 18 m back in reverse")
        place, heading = figure.subplots(1, 2)
        for label, errors, color, marker, filled in series:
            draw_dots(place, 1e3 * errors[:, :2], color, marker, filled=filled, label=label)
            runs = np.column_stack([np.arange(1.0, 4.0), np.degrees(errors[:, 2])])
            draw_dots(heading, runs, color, marker, filled=filled)
        draw_cross(place)
        place.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]", title="position")
        heading.axhspan(-1.0, 1.0, color=GREEN, alpha=0.12, linewidth=0.0)
        heading.axhline(0.0, color=GREY, linewidth=0.8)
        heading.text(3.35, 1.1, "printed bound with IPEC, ±1°", color=GREEN, ha="right", va="bottom")
        heading.set(xlabel="run", ylabel="return error of the heading [°]", title="heading")
        heading.set(xticks=(1, 2, 3), xlim=(0.6, 3.4))
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)


def draw_c10(path: Path) -> None:
    """Draw C Fig. 10: return positions after the rectangle, whole and enlarged."""
    smooth, bumpy = rectangle_errors(ROBOT, 0), rectangle_errors(ROBOT, 10)
    series = (
        ("without IPEC, 10 bumps", bumpy["plain"], VERMILLION, "*", True),
        ("with IPEC, 10 bumps", bumpy["CLAPPER"], BLUE, "s", False),
        ("with IPEC, no bumps", smooth["CLAPPER"], GREEN, "o", False),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 5.9), layout="constrained")
        figure.suptitle("C Fig. 10, simulated: 7 x 4 m rectangle from its corner, cw and ccw")
        panels: tuple[Axes, Axes] = tuple(figure.subplots(1, 2))
        for axes, title, limit in zip(panels, ("all runs", "enlarged"), (None, 80.0), strict=True):
            for label, errors, color, marker, filled in series:
                mean = sizes(errors)[1].mean()
                words = f"{label}: mean |heading error| {mean:.2f}°"
                draw_dots(axes, 1e3 * errors[:, :2], color, marker, filled=filled, label=words)
            draw_cross(axes)
            _ring(axes, 50.0)
            axes.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]", title=title)
            axes.set_aspect("equal", adjustable="datalim" if limit is None else "box")
            if limit is not None:
                axes.set(xlim=(-limit, limit), ylim=(-limit, limit))
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=1)
        save(figure, path)


def _ring(axes: Axes, radius: float) -> None:
    """Draw C 6.2's bound of 5 cm."""
    angle: Sequence[float] | Array = np.linspace(0.0, 2.0 * np.pi, 181)
    label = "printed bound with IPEC, 50 mm"
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), "--", color=GREY, linewidth=1.0, label=label)
