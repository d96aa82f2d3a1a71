"""Figures of real robots: what better numbers leave, and how far a robot turns for what its wheels say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from figures.plots import BLUE, GREEN, GREY, STYLE, VERMILLION, check_format, save

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from vehicle.se2 import Array

_MARKS = ((GREY, "o"), (BLUE, "s"), (VERMILLION, "^"))


def plot_errors(names: Sequence[str], columns: Mapping[str, Sequence[float]], path: Path) -> None:
    """Draw position errors [m], as mm, of sets by up to three ways to better numbers.

    Raises:
        PlotError: the file cannot be written.
    """
    check_format(path)
    rows = np.arange(len(names))[::-1]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 0.34 * len(names) + 1.6), layout="constrained")
        axes = figure.subplots()
        for (label, values), (color, marker) in zip(columns.items(), _MARKS, strict=False):
            axes.plot(
                1e3 * np.array(values), rows, marker, color=color, label=label, markersize=6, alpha=0.85
            )
        axes.set_yticks(rows, names)
        axes.set(xlabel="position error after 10 s of open loop, rms [mm]")
        axes.set_xlim(left=0.0)
        figure.legend(loc="outside lower center", ncols=3)
        save(figure, path)


def plot_turns(wheels: Array, measured: Array, ratio: float, path: Path, *, title: str = "") -> None:
    """Draw how far a robot turned over how far its wheels say that it did.

    Args:
        wheels: (N,) turn of each drive by the wheels and the described robot [rad].
        measured: (N,) likewise, measured from outside [rad].
        ratio: of the turns by the wheels to those that were found.
        path: of the file, by whose suffix the format is chosen.
        title: above the figure.

    Raises:
        PlotError: the file cannot be written.
    """
    check_format(path)
    ends = np.array([-1.0, 1.0]) * float(np.degrees(np.abs(wheels).max()))
    limit = 1.15 * float(np.degrees(np.abs(measured).max()))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 5.2), layout="constrained")
        axes = figure.subplots()
        axes.plot(np.degrees(wheels), np.degrees(measured), ".", color=GREY, markersize=4, alpha=0.6)
        axes.plot(ends, ends, "--", color=VERMILLION, label="as described")
        axes.plot(ends, ends / ratio, color=GREEN, label=f"as found: divided by {ratio:.2f}")
        axes.set(xlabel="turn by the wheels [degrees]", ylabel="turn measured [degrees]", title=title)
        axes.set_ylim(-limit, limit)
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)
