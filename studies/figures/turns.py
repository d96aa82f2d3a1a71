"""The measured turns of a robot over the turns by its wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import check_format, save
from omnimate.figures.style import GREEN, GREY, STYLE, VERMILLION

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.vehicle.se2 import Array


def plot_turns(wheels: Array, measured: Array, ratio: float, path: Path, *, title: str = "") -> None:
    """Draw the measured turns of a robot over the turns by its wheels.

    Args:
        wheels: Turn of each drive by the wheels and the described robot [rad], shape `(N,)`.
        measured: Turn of each drive, measured from outside [rad], shape `(N,)`.
        ratio: Ratio of the turns by the wheels to the fitted ones.
        path: Path of the file; its suffix gives the format.
        title: Title above the figure.

    Raises:
        PlotError: The file cannot be written.
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
