"""Figures: clusters of return errors as in U Fig. 6 and 11, and the floor plan of a drive.

Colours are those of Okabe and Ito, which colour-blind people tell apart; shapes say the same once more.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from vehicle.atomic import write_bytes
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from calib.return_errors import ReturnErrors
    from vehicle.se2 import Array

FORMATS = (".png", ".svg", ".pdf")

BLUE, VERMILLION, GREEN, PURPLE, ORANGE = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"
GREY = "#5A5A5A"
_TRACKS = (GREY, BLUE, VERMILLION, GREEN, PURPLE, ORANGE)
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "svg.hashsalt": "omnimate",
}


class PlotError(OmnimateError):
    """A figure that cannot be written.

    Attributes:
        path: where it should have gone.
    """

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path


@dataclass(frozen=True, slots=True)
class Clusters:
    """What one panel of a cluster figure shows.

    Attributes:
        title: above the panel.
        before: return errors of the uncalibrated truck.
        after: those of the calibrated one; None for U Fig. 6, which has none.
    """

    title: str
    before: ReturnErrors
    after: ReturnErrors | None = None


@dataclass(frozen=True, slots=True)
class Track:
    """One line of a floor plan.

    Attributes:
        label: in the legend.
        path: (N, 2) or (N, 3), x and y first [m].
        dashed: for what was calculated, beside what was driven.
    """

    label: str
    path: Array
    dashed: bool = False


def check_format(path: Path) -> None:
    """Refuse a file name that says no known format of pictures, or whose folder is not there.

    Raises:
        PlotError: it does, or is not.
    """
    if path.suffix.lower() not in FORMATS:
        raise PlotError(path, f"unknown format {path.suffix!r}; expected a name with {', '.join(FORMATS)}")
    if not path.absolute().parent.is_dir():
        raise PlotError(path, "its folder is not there; create it first")


def plot_clusters(panels: Sequence[Clusters], path: Path) -> None:
    """Draw return errors [mm] with their centres of gravity and E_max,syst, as U Fig. 11 does.

    Raises:
        PlotError: the file cannot be written.
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
    """Return the panel's title with its E_max,syst, which would hide points beside its circle."""
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


def plot_floor_plan(
    tracks: Sequence[Track], path: Path, *, title: str = "", fixes: Array | None = None
) -> None:
    """Draw paths over the floor [m], the driven one beside what odometry makes of it.

    Args:
        tracks: one line each; the first one is grey and wide, as what the others are measured against.
        path: of the file, by whose suffix the format is chosen.
        title: above the figure.
        fixes: (M, 2) or (M, 3) absolute poses, x and y first [m].

    Raises:
        PlotError: the file cannot be written.
    """
    check_format(path)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 6.6), layout="constrained")
        axes = figure.subplots()
        for number, (track, color) in enumerate(zip(tracks, _cycle(len(tracks)), strict=True)):
            width, line = (3.2 if number == 0 else 1.3), ("--" if track.dashed else "-")
            alpha = 0.55 if number == 0 else 1.0
            x, y = track.path[:, 0], track.path[:, 1]
            axes.plot(x, y, line, color=color, linewidth=width, alpha=alpha, label=track.label)
            axes.plot(x[-1:], y[-1:], "o", color=color, markersize=6, markeredgecolor="white", zorder=4)
        if fixes is not None:
            label = "absolute fix"
            axes.plot(
                fixes[:, 0], fixes[:, 1], "k+", markersize=9, markeredgewidth=1.4, label=label, zorder=5
            )
        axes.set(xlabel="x [m]", ylabel="y [m]", title=title)
        axes.set_aspect("equal", adjustable="datalim")
        figure.legend(loc="outside lower center", ncols=2)
        save(figure, path)


def _cycle(count: int) -> list[str]:
    return [_TRACKS[number % len(_TRACKS)] for number in range(count)]


def _millimetres(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.1f}"


def save(figure: Figure, path: Path) -> None:
    """Write a figure whole or not at all.

    Raises:
        PlotError: the file cannot be written.
    """
    try:
        write_bytes(path, rendered(figure, path.suffix.lower().removeprefix(".")))
    except OSError as error:
        raise PlotError(path, f"cannot be written: {error}") from error


def rendered(figure: Figure, kind: str) -> bytes:
    """Return a figure as a png, svg or pdf: the same bytes for the same content."""
    buffer = io.BytesIO()
    stamp = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    with mpl.rc_context(STYLE):
        figure.savefig(buffer, format=kind, dpi=160, metadata=stamp)
    return buffer.getvalue()
