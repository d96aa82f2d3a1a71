"""Signals of a message over time, one panel for each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure

from omnimate.figures.files import save
from omnimate.figures.style import BLUE, GREY, STYLE

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

MOST_POINTS = 5000  # of a panel: more than its pixels


def plot_signals(
    title: str,
    signals: Sequence[tuple[str, NDArray[np.float64], NDArray[np.float64]]],
    path: Path,
) -> None:
    """Draw the signals of a message.

    A signal is its name, times [s] and values, both of shape `(N,)`.

    Raises:
        PlotError: The picture cannot be written.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 0.7 + 1.25 * len(signals)), layout="constrained")
        panels = figure.subplots(len(signals), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, time, value) in zip(panels, signals, strict=True):
            step = max(1, len(time) // MOST_POINTS)
            axes.plot(time[::step], value[::step], color=BLUE, linewidth=0.8, drawstyle="steps-post")
            axes.set_title(name, loc="left", fontsize=9, color=GREY)
            axes.tick_params(labelsize=8)
        panels[-1].set_xlabel("time [s]")
        figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    save(figure, path)
