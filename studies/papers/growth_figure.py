"""The figure of C 3.3: growth of heading and lateral error after a bump."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from omnimate.figures.files import save
from omnimate.figures.style import BLUE, GREEN, GREY, STYLE, VERMILLION
from studies.papers.growth import bump_growth

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes

    from studies.papers.growth import Growth


def draw_growth(path: Path) -> None:
    """Draw C 3.3: heading error at once, lateral error slowly, and what IPEC leaves of both."""
    growth = bump_growth()
    number = np.arange(len(growth.plain))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 5.2), layout="constrained")
        figure.suptitle("C 3.3, simulated: one 10 mm bump under a right wheel, 0.5 m/s, 20 mm per interval")
        heading, lateral = figure.subplots(1, 2)
        for axes, column, scale in ((heading, 0, np.degrees(1.0)), (lateral, 1, 1e3)):
            axes.plot(number, scale * growth.plain[:, column], "s-", color=VERMILLION, label="plain odometry")
            axes.plot(number, scale * growth.ipec[:, column], "o-", color=BLUE, label="IPEC, C (9)-(16)")
            axes.set_xlabel("sampling interval of 40 ms since the bump is met")
        seen = np.degrees(growth.seen)
        heading.plot(number, seen, "x--", color=GREEN, label="internal: seen by the linkage")
        _annotate_growth(heading, lateral, growth)
        figure.legend(*heading.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        save(figure, path)


def _annotate_growth(heading: Axes, lateral: Axes, growth: Growth) -> None:
    printed = growth.printed
    whole, seen = -np.degrees(printed.heading), -np.degrees(printed.measured)
    heading.axhline(whole, color=GREY, linewidth=0.8, linestyle=":")
    heading.text(15, whole + 0.03, f"C (4): {-whole:.2f}°,  C (8): {-seen:.2f}° measured", ha="right")
    heading.set(ylabel="heading, true minus estimated [°]", title="fast: there within one interval")
    number = np.arange(len(growth.plain))
    law = -1e3 * printed.lateral_in_interval * np.maximum(number - 0.5, 0.0)
    words = f"C (6): {1e3 * printed.lateral_in_interval:.2f} mm per interval"
    lateral.plot(number, law, color=GREY, linewidth=0.8, linestyle=":")
    lateral.text(7.0, float(law[10]), words, ha="right", va="top", color=GREY)
    lateral.set(ylabel="lateral, true minus estimated [mm]", title="slow: grows with the way driven")
