"""The figures of O 3: return positions and headings of laps, with and without IPEC."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import save
from omnimate.figures.style import BLUE, GREY, STYLE, VERMILLION
from studies.papers.figure_parts import ROBOT, draw_cross, draw_dots
from studies.papers.lap_table import lap_errors_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from matplotlib.axes import Axes

    from omnimate.vehicle.se2 import Array
    from studies.papers.drives import Turning

_WAYS: tuple[tuple[Turning, str], ...] = (("cw", BLUE), ("ccw", VERMILLION))
_IPEC = {"filled": "with IPEC", "open": "without IPEC"}


def draw_positions(path: Path, number: int, laps: slice) -> None:
    """Draw O Fig. 5 or 7: return positions of laps 1-5 or 6-10, all and enlarged."""
    bumps = "no bumps" if laps.start == 0 else "20 bumps of 9 mm"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.0, 5.6), layout="constrained")
        figure.suptitle(f"O Fig. {number}, simulated: return positions after laps of 18.5 m, {bumps}")
        panels: tuple[Axes, Axes] = tuple(figure.subplots(1, 2))
        corrected = []
        for axes in panels:
            for way, color, label, errors, filled in _laps(laps):
                marker = "o" if way == "cw" else "s"
                draw_dots(axes, 1e3 * errors[:, :2], color, marker, filled=filled, label=label)
                corrected += [1e3 * np.abs(errors[:, :2]).max()] if filled else []
            draw_cross(axes)
            axes.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]")
        limit = 1.3 * max(corrected)
        panels[0].set(title="all runs")
        panels[0].set_aspect("equal", adjustable="datalim")
        panels[1].set(title="enlarged", aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        save(figure, path)


def draw_headings(path: Path, number: int, laps: slice) -> None:
    """Draw O Fig. 6 or 8: return headings by lap."""
    bumps = "no bumps" if laps.start == 0 else "20 bumps of 9 mm"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 5.2), layout="constrained")
        figure.suptitle(f"O Fig. {number}, simulated: return headings after laps of 18.5 m, {bumps}")
        axes = figure.subplots()
        for way, color, label, errors, filled in _laps(laps):
            lap = np.arange(laps.start + 1.0, laps.start + 1.0 + len(errors))
            points = np.column_stack([lap, np.degrees(errors[:, 2])])
            axes.plot(*points.T, color=color, linewidth=0.8, linestyle="-" if filled else ":")
            draw_dots(axes, points, color, "o" if way == "cw" else "s", filled=filled, label=label)
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        axes.set(xlabel="lap", ylabel="return error of the heading [°]")
        axes.set_xticks(range(laps.start + 1, laps.stop + 1))
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)


def _laps(laps: slice) -> Iterator[tuple[Turning, str, str, Array, bool]]:
    """Yield direction, colour, label, return errors and whether IPEC ran, of O's four sets."""
    for name, filled in (("plain", False), ("OmniMate", True)):
        for way, color in _WAYS:
            errors = lap_errors_of(ROBOT, way)["OmniMate" if filled else "plain"][laps]
            last = 4 if name == "plain" and laps.start else 5  # O drove lap 10 with IPEC only
            yield way, color, f"{way}, {_IPEC['filled' if filled else 'open']}", errors[:last], filled
