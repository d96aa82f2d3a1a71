"""The share of an effect's gain that is recovered by what is learned without knowing it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREY, ORANGE, STYLE, VERMILLION

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

_MARKS = ((VERMILLION, "o"), (BLUE, "s"), (ORANGE, "^"))
_LEAST = -0.2  # share below which marks are drawn at the edge


def plot_recovery(found: Mapping[str, Mapping[str, Sequence[float]]], wanted: float, path: Path) -> None:
    """Draw shares that are recovered, a row for each effect, up to three methods beside each other.

    Args:
        found: Shares of single cases, by effect and method.
        wanted: Share that is wanted; drawn as a line.
        path: Path of the file; its suffix gives the format.

    Raises:
        PlotError: The file cannot be written.
    """
    check_format(path)
    methods = list(next(iter(found.values())))
    rows = np.arange(len(found))[::-1]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 0.34 * len(found) + 1.6), layout="constrained")
        axes = figure.subplots()
        axes.axvline(wanted, color=GREY, linestyle="--", linewidth=1.0)
        for number, (method, (color, marker)) in enumerate(zip(methods, _MARKS, strict=False)):
            at = [
                row + 0.22 * (1 - number)
                for row, own in zip(rows, found.values(), strict=True)
                for _ in own[method]
            ]
            values = [max(value, _LEAST) for own in found.values() for value in own[method]]
            axes.plot(values, at, marker, color=color, label=method, markersize=5, alpha=0.8)
        axes.set_ylim(-0.6, len(found) - 0.4)
        axes.set_yticks(rows, [name.replace("_", " ") for name in found])
        axes.set(
            xlabel="share of the effect's gain that is recovered on an unseen drive",
            xlim=(_LEAST - 0.05, 1.1),
        )
        figure.legend(loc="outside lower center", ncols=3)
        save(figure, path)
