"""The efficiency with which effects of known strength are found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREY, STYLE, VERMILLION

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array

_BINS = 8
_JITTER = 0.03  # of the axis, by which the marks of single injections are spread


class Efficiency(Protocol):
    """Injections by their strength, and the share that is found."""

    @property
    def strength(self) -> Array:
        """Strength of each injection, in standard deviations, shape `(N,)`."""
        ...

    @property
    def found(self) -> NDArray[np.bool_]:
        """Whether each was found, shape `(N,)`."""
        ...

    @property
    def half(self) -> float:
        """The strength that is found half of the time; infinite for none."""
        ...

    def at(self, strength: Array) -> Array:
        """Return the fitted share that is found at strengths of any shape."""
        ...


def plot_efficiency(efficiency: Efficiency, path: Path, *, bound: float = 5.0, title: str = "") -> None:
    """Draw the share of injections that is found, over their strength.

    Args:
        efficiency: The injections and the fit.
        path: Path of the file; its suffix gives the format.
        bound: Strength beside which that found half of the time is judged [sigma].
        title: Title above the figure.

    Raises:
        PlotError: The file cannot be written.
    """
    check_format(path)
    strength, found = efficiency.strength, efficiency.found
    order = np.argsort(strength)
    fine = np.geomspace(strength.min(), strength.max(), 200)
    spread = _JITTER * np.sin(37.0 * np.arange(len(strength)))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.0, 4.0), layout="constrained")
        axes = figure.subplots()
        axes.plot(strength, found + spread, "|", color=GREY, markersize=5, alpha=0.5, label="one injection")
        for part in np.array_split(order, min(_BINS, len(order))):
            share = found[part].mean()
            width = np.sqrt(share * (1.0 - share) / len(part))
            middle = float(np.exp(np.log(strength[part]).mean()))
            axes.errorbar(middle, share, width, fmt="o", color=BLUE, markersize=5, capsize=2)
        axes.plot(fine, efficiency.at(fine), color=BLUE, label="logistic fit")
        axes.axvline(bound, color=GREY, linestyle=":", label=f"{bound:g} sigma")
        if np.isfinite(efficiency.half):
            label = f"found half of the time: {efficiency.half:.1f} sigma"
            axes.axvline(efficiency.half, color=VERMILLION, linestyle="--", label=label)
        axes.set(xscale="log", ylim=(-0.06, 1.06), title=title)
        axes.set(
            xlabel="strength in the recording [sigma of the Cramer-Rao bound]",
            ylabel="share that is found",
        )
        axes.set_xticks([1, 2, 5, 10, 20, 30], ["1", "2", "5", "10", "20", "30"])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlim(min(0.9, float(strength.min())), max(35.0, float(strength.max())))
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)
