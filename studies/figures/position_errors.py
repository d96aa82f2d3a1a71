"""Position errors of sets of recordings, by up to three ways to better parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREY, STYLE, VERMILLION

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

_MARKS = ((GREY, "o"), (BLUE, "s"), (VERMILLION, "^"))


def plot_errors(names: Sequence[str], columns: Mapping[str, Sequence[float]], path: Path) -> None:
    """Draw position errors of sets, by up to three ways to better parameters.

    Args:
        names: Names of the sets.
        columns: Position errors of all sets [m], by the label of the way; drawn in mm.
        path: Path of the file; its suffix gives the format.

    Raises:
        PlotError: The file cannot be written.
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
