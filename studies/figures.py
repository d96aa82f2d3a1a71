"""Figures that only studies draw: each with a check of its file's name, and a legend below."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from omnimate.figures.files import check_format, save
from omnimate.figures.style import BLUE, GREEN, GREY, ORANGE, STYLE, VERMILLION
from omnimate.vehicle.se2 import Array
from studies.mismatch.scoring.efficiency import Efficiency
from studies.mismatch.scoring.score import Bin

BOUND = 5.0  # [sigma] with which the strength that is found half of the time is compared
BINS = 8  # of the injections by their strength
JITTER = 0.03  # of the axis, by which the marks of single injections are spread
LEAST_SHARE = -0.2  # recovered share below which marks are drawn at the edge
COLUMNS = 4  # panels in a row


@contextmanager
def framed(path: Path, size: tuple[float, float], legend_columns: int = 0) -> Iterator[Figure]:
    """Yield a figure of a size [inch] in the project's style, and save it at the end of the block.

    The suffix of the path gives the format; a legend is that of the first axes, and is below all of them.
    PlotError: the file cannot be written.
    """
    check_format(path)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        yield figure
        if legend_columns:
            shown = figure.axes[0].get_legend_handles_labels()
            figure.legend(*shown, loc="outside lower center", ncols=legend_columns)
        save(figure, path)


def plot_efficiency(efficiency: Efficiency, path: Path, title: str) -> None:
    """Draw the share of injections that is found, over their strength."""
    strength, found = efficiency.strength, efficiency.found
    order = np.argsort(strength)
    fine = np.geomspace(strength.min(), strength.max(), 200)
    spread = JITTER * np.sin(37.0 * np.arange(len(strength)))
    with framed(path, (6.0, 4.0), 2) as figure:
        axes = figure.subplots()
        axes.plot(strength, found + spread, "|", color=GREY, markersize=5, alpha=0.5, label="one injection")
        for part in np.array_split(order, min(BINS, len(order))):
            share = found[part].mean()
            width = np.sqrt(share * (1.0 - share) / len(part))
            middle = float(np.exp(np.log(strength[part]).mean()))
            axes.errorbar(middle, share, width, fmt="o", color=BLUE, markersize=5, capsize=2)
        axes.plot(fine, efficiency.at(fine), color=BLUE, label="logistic fit")
        axes.axvline(BOUND, color=GREY, linestyle=":", label=f"{BOUND:g} sigma")
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


def plot_errors(names: Sequence[str], columns: Mapping[str, Sequence[float]], path: Path) -> None:
    """Draw position errors [m] of sets, by up to three ways to better parameters; in mm."""
    rows = np.arange(len(names))[::-1]
    marks = (GREY, "o"), (BLUE, "s"), (VERMILLION, "^")
    with framed(path, (7.4, 0.34 * len(names) + 1.6), 3) as figure:
        axes = figure.subplots()
        for (label, values), (color, marker) in zip(columns.items(), marks, strict=False):
            axes.plot(
                1e3 * np.array(values), rows, marker, color=color, label=label, markersize=6, alpha=0.85
            )
        axes.set_yticks(rows, names)
        axes.set(xlabel="position error after 10 s of open loop, rms [mm]")
        axes.set_xlim(left=0.0)


def plot_recovery(recoveries: Mapping[str, Mapping[str, Sequence[float]]], wanted: float, path: Path) -> None:
    """Draw shares that are recovered, a row for each effect, up to three methods next to each other."""
    methods = list(next(iter(recoveries.values())))
    rows = np.arange(len(recoveries))[::-1]
    marks = (VERMILLION, "o"), (BLUE, "s"), (ORANGE, "^")
    with framed(path, (7.4, 0.34 * len(recoveries) + 1.6), 3) as figure:
        axes = figure.subplots()
        axes.axvline(wanted, color=GREY, linestyle="--", linewidth=1.0)
        for number, (method, (color, marker)) in enumerate(zip(methods, marks, strict=False)):
            at = [
                row + 0.22 * (1 - number)
                for row, by_method in zip(rows, recoveries.values(), strict=True)
                for _ in by_method[method]
            ]
            values = [
                max(value, LEAST_SHARE) for by_method in recoveries.values() for value in by_method[method]
            ]
            axes.plot(values, at, marker, color=color, label=method, markersize=5, alpha=0.8)
        axes.set_ylim(-0.6, len(recoveries) - 0.4)
        axes.set_yticks(rows, [name.replace("_", " ") for name in recoveries])
        axes.set(
            xlabel="share of the effect's gain that is recovered on an unseen drive",
            xlim=(LEAST_SHARE - 0.05, 1.1),
        )


def plot_reliability(panels: Mapping[str, Sequence[Bin]], path: Path) -> None:
    """Draw a reliability diagram for each world; who is as sure as right lies on the diagonal."""
    columns = min(COLUMNS, len(panels))
    count = -(-len(panels) // columns)
    with framed(path, (2.6 * columns + 0.5, 2.7 * count + 0.4)) as figure:
        grid = figure.subplots(count, columns, sharex=True, sharey=True, squeeze=False)
        for axes, (title, bins) in zip(grid.flat, panels.items(), strict=False):
            axes.plot([0.0, 1.0], [0.0, 1.0], "--", color=GREY, linewidth=1.0)
            said, share = (
                np.array([interval_bin.said for interval_bin in bins]),
                np.array([interval_bin.share for interval_bin in bins]),
            )
            ends = np.array([interval_bin.interval for interval_bin in bins]).reshape(-1, 2)
            reach = np.abs(ends.T - share)
            axes.errorbar(said, share, reach, fmt="o-", color=BLUE, markersize=4, linewidth=1.0, capsize=2)
            for interval_bin in bins:
                axes.annotate(
                    str(interval_bin.of),
                    (interval_bin.said, interval_bin.share),
                    (4, -9 if interval_bin.share > 0.5 else 4),
                    textcoords="offset points",
                    fontsize=7,
                )
            axes.set(title=title, xlim=(-0.03, 1.03), ylim=(-0.03, 1.03), aspect="equal")
            axes.set_xticks([0.0, 0.5, 1.0])
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        figure.supxlabel("probability that was said", fontsize=10)
        figure.supylabel("share that is right, 95 % interval", fontsize=10)


def plot_turns(wheels: Array, measured: Array, ratio: float, path: Path, *, title: str = "") -> None:
    """Draw the measured turns of a robot [rad] over those by its wheels as described, each `(N,)`.

    `ratio` is that of the turns by the wheels to the fitted ones.
    """
    ends = np.array([-1.0, 1.0]) * float(np.degrees(np.abs(wheels).max()))
    limit = 1.15 * float(np.degrees(np.abs(measured).max()))
    with framed(path, (6.4, 5.2), 2) as figure:
        axes = figure.subplots()
        axes.plot(np.degrees(wheels), np.degrees(measured), ".", color=GREY, markersize=4, alpha=0.6)
        axes.plot(ends, ends, "--", color=VERMILLION, label="as described")
        axes.plot(ends, ends / ratio, color=GREEN, label=f"as found: divided by {ratio:.2f}")
        axes.set(xlabel="turn by the wheels [degrees]", ylabel="turn measured [degrees]", title=title)
        axes.set_ylim(-limit, limit)
