"""Clusters of return errors, as in U Fig. 6 and 11."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREEN, GREY, STYLE, VERMILLION

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from omnimate.calib.umbmark.return_errors import ReturnErrors


@dataclass(frozen=True, slots=True)
class Clusters:
    """The content of one panel of a cluster figure.

    `after` is None for a figure such as U Fig. 6, which has none.
    """

    title: str
    before: ReturnErrors
    after: ReturnErrors | None = None


def plot_clusters(panels: Sequence[Clusters], path: Path) -> None:
    """Draw return errors [mm] with their centres of gravity and E_max,syst, as U Fig. 11 does.

    Raises:
        PlotError: The file cannot be written.
    """
    check_format(path)
    save(cluster_figure(panels), path)


def cluster_figure(panels: Sequence[Clusters]) -> Figure:
    """Return the figure of `plot_clusters`."""
    columns = min(len(panels), 2)
    rows = -(-len(panels) // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.4 * columns, 5.2 * rows + 1.3), layout="constrained")
        for axes, panel in zip(figure.subplots(rows, columns, squeeze=False).flat, panels, strict=False):
            _draw_clusters(axes, panel)
        for axes in figure.axes[len(panels) :]:
            axes.set_axis_off()
        after = any(panel.after is not None for panel in panels)
        figure.legend(handles=_cluster_legend(after=after), loc="outside lower center", ncols=2)
    return figure


def _draw_clusters(axes: Axes, panel: Clusters) -> None:
    stages = [stage for stage in (panel.before, panel.after) if stage is not None]
    limit = 1.08e3 * max(max(stage.worst, stage.e_max_syst) for stage in stages)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    for stage, filled in zip(stages, (False, True), strict=False):
        _draw_stage(axes, stage, filled=filled)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", title=_title(panel))
    axes.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]")


def _draw_stage(axes: Axes, errors: ReturnErrors, *, filled: bool) -> None:
    """Draw both clusters of one stage, their centres of gravity, and the circle of E_max,syst."""
    for runs, centre, color, marker in (
        (errors.cw, errors.centres[0], BLUE, "o"),
        (errors.ccw, errors.centres[1], VERMILLION, "s"),
    ):
        face = color if filled else "white"
        x, y = 1e3 * runs[:, 0], 1e3 * runs[:, 1]
        axes.scatter(x, y, s=30, marker=marker, facecolors=face, edgecolors=color, linewidths=1.2, zorder=3)
        if not filled:
            axes.plot([0.0, 1e3 * centre[0]], [0.0, 1e3 * centre[1]], color=color, linewidth=0.9, zorder=2)
        axes.scatter(
            1e3 * centre[0],
            1e3 * centre[1],
            s=50 if filled else 120,
            marker="+",
            color="black",
            linewidths=1.6,
            zorder=4,
        )
    color, line = (GREEN, "-") if filled else (GREY, "--")
    radius = 1e3 * errors.e_max_syst
    axes.add_patch(Circle((0.0, 0.0), radius, fill=False, edgecolor=color, linestyle=line, linewidth=1.4))


def _title(panel: Clusters) -> str:
    """Return the panel's title with its E_max,syst; a label next to its circle would hide points."""
    before = f"{_millimetres(1e3 * panel.before.e_max_syst)} mm"
    sizes = before
    if panel.after is not None:
        sizes = f"{before} before, {_millimetres(1e3 * panel.after.e_max_syst)} mm after"
    return f"{panel.title}\n" + rf"$E_\mathrm{{max,syst}}$ {sizes}"


def _cluster_legend(*, after: bool) -> list[Line2D]:
    """Return the legend's entries: directions, stages and the centre of gravity."""

    def dots(color: str, marker: str, label: str, *, filled: bool) -> Line2D:
        face = color if filled else "white"
        return Line2D([], [], color=color, marker=marker, markerfacecolor=face, linestyle="", label=label)

    handles: list[Line2D] = []
    for word, filled in (("before", False), ("after", True)) if after else (("", False),):
        tail = f", {word}" if word else ""
        circle = Line2D([], [], color=GREEN if filled else GREY, linestyle="-" if filled else "--")
        circle.set_label(rf"$E_\mathrm{{max,syst}}${tail}")
        handles += [
            dots(BLUE, "o", f"cw{tail}", filled=filled),
            dots(VERMILLION, "s", f"ccw{tail}", filled=filled),
            circle,
        ]
    centre = Line2D([], [], color="black", marker="+", linestyle="", label="centre of gravity")
    return [*handles[:3], centre, *handles[3:]]


def _millimetres(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}"
