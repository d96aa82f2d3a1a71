"""The papers' figures, drawn from simulated drives: U 6 and 11, C 8 and 10, O 5-8, and C's growth rates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from omnimate.figures.clusters import Clusters, plot_clusters
from omnimate.figures.files import PlotError
from omnimate.figures.style import BLUE, GREEN, GREY, VERMILLION
from omnimate.vehicle.se2 import Array
from studies.figures import framed
from studies.papers.bumps import Growth, bump_growth
from studies.papers.protocols import lap_errors_of, rectangle_errors, sizes, straight_errors
from studies.papers.robots import Turning
from studies.papers.squares import FIGURE_11, stages_of

# Label, return errors `(N, 3)`, colour and mark of a set, and whether its marks are filled.
Series = tuple[str, Array, str, str, bool]
ROBOT = 0  # the papers show a single robot; this is the first of the table


def draw_dots(
    axes: Axes, points: Array, color: str, marker: str, *, filled: bool, label: str | None = None
) -> None:
    """Draw points `(N, 2)` as filled or open marks."""
    face = color if filled else "white"
    x, y = points[:, 0], points[:, 1]
    axes.scatter(
        x, y, s=42, marker=marker, facecolors=face, edgecolors=color, linewidths=1.2, label=label, zorder=3
    )


def draw_cross(axes: Axes) -> None:
    """Draw the axes through the origin."""
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    axes.axvline(0.0, color=GREY, linewidth=0.8)


def draw_c8(path: Path) -> None:
    """Draw C Fig. 8: return positions and headings of 18 m out and back, 3 runs of each condition."""
    smooth, bumpy = straight_errors(ROBOT, 0), straight_errors(ROBOT, 10)
    series = (
        ("without IPEC, no bumps", smooth["plain"], GREY, "o", False),
        ("without IPEC, 10 bumps under each truck", bumpy["plain"], VERMILLION, "s", False),
        ("with IPEC, no bumps", smooth["CLAPPER"], GREEN, "o", True),
        ("with IPEC, 10 bumps under each truck", bumpy["CLAPPER"], BLUE, "s", True),
    )
    with framed(path, (10.0, 5.4), 2) as figure:
        figure.suptitle("C Fig. 8, simulated: 18 m straight out and 18 m back in reverse")
        place, heading = figure.subplots(1, 2)
        for label, errors, color, marker, filled in series:
            draw_dots(place, 1e3 * errors[:, :2], color, marker, filled=filled, label=label)
            runs = np.column_stack([np.arange(1.0, 4.0), np.degrees(errors[:, 2])])
            draw_dots(heading, runs, color, marker, filled=filled)
        draw_cross(place)
        place.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]", title="position")
        heading.axhspan(-1.0, 1.0, color=GREEN, alpha=0.12, linewidth=0.0)
        heading.axhline(0.0, color=GREY, linewidth=0.8)
        heading.text(3.35, 1.1, "printed bound with IPEC, ±1°", color=GREEN, ha="right", va="bottom")
        heading.set(xlabel="run", ylabel="return error of the heading [°]", title="heading")
        heading.set(xticks=(1, 2, 3), xlim=(0.6, 3.4))


def draw_c10(path: Path) -> None:
    """Draw C Fig. 10: return positions after the rectangle, whole and enlarged."""
    smooth, bumpy = rectangle_errors(ROBOT, 0), rectangle_errors(ROBOT, 10)
    series = (
        ("without IPEC, 10 bumps", bumpy["plain"], VERMILLION, "*", True),
        ("with IPEC, 10 bumps", bumpy["CLAPPER"], BLUE, "s", False),
        ("with IPEC, no bumps", smooth["CLAPPER"], GREEN, "o", False),
    )
    with framed(path, (10.4, 5.9), 1) as figure:
        figure.suptitle("C Fig. 10, simulated: 7 x 4 m rectangle from its corner, cw and ccw")
        words = [
            (f"{label}: mean |heading error| {sizes(errors)[1].mean():.2f}°", errors, color, marker, filled)
            for label, errors, color, marker, filled in series
        ]
        for axes in _draw_twice(figure, words, 80.0):
            _ring(axes, 50.0)


def _draw_twice(figure: Figure, series: Iterable[Series], limit: float) -> tuple[Axes, Axes]:
    """Draw return positions in two panels: all of them, and those within a limit [mm]."""
    whole, enlarged = figure.subplots(1, 2)
    for axes in (whole, enlarged):
        for label, errors, color, marker, filled in series:
            draw_dots(axes, 1e3 * errors[:, :2], color, marker, filled=filled, label=label)
        draw_cross(axes)
        axes.set(xlabel="return error in x [mm]", ylabel="return error in y [mm]")
    whole.set(title="all runs")
    whole.set_aspect("equal", adjustable="datalim")
    enlarged.set(title="enlarged", aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
    return whole, enlarged


def _ring(axes: Axes, radius: float) -> None:
    """Draw C 6.2's bound of 5 cm."""
    angle: Sequence[float] | Array = np.linspace(0.0, 2.0 * np.pi, 181)
    label = "printed bound with IPEC, 50 mm"
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), "--", color=GREY, linewidth=1.0, label=label)


_WAYS: tuple[tuple[Turning, str, str], ...] = (("cw", BLUE, "o"), ("ccw", VERMILLION, "s"))


def draw_positions(path: Path, number: int, laps: slice) -> None:
    """Draw O Fig. 5 or 7: return positions of laps 1-5 or 6-10, all and enlarged."""
    bumps = "no bumps" if laps.start == 0 else "20 bumps of 9 mm"
    with framed(path, (10.0, 5.6), 2) as figure:
        figure.suptitle(f"O Fig. {number}, simulated: return positions after laps of 18.5 m, {bumps}")
        series = list(_laps(laps))
        largest = max(np.abs(errors[:, :2]).max() for _, errors, *_, filled in series if filled)
        _draw_twice(figure, series, 1.3 * 1e3 * float(largest))


def draw_headings(path: Path, number: int, laps: slice) -> None:
    """Draw O Fig. 6 or 8: return headings by lap."""
    bumps = "no bumps" if laps.start == 0 else "20 bumps of 9 mm"
    with framed(path, (7.4, 5.2), 2) as figure:
        figure.suptitle(f"O Fig. {number}, simulated: return headings after laps of 18.5 m, {bumps}")
        axes = figure.subplots()
        for label, errors, color, marker, filled in _laps(laps):
            lap = np.arange(laps.start + 1.0, laps.start + 1.0 + len(errors))
            points = np.column_stack([lap, np.degrees(errors[:, 2])])
            axes.plot(*points.T, color=color, linewidth=0.8, linestyle="-" if filled else ":")
            draw_dots(axes, points, color, marker, filled=filled, label=label)
        axes.axhline(0.0, color=GREY, linewidth=0.8)
        axes.set(xlabel="lap", ylabel="return error of the heading [°]")
        axes.set_xticks(range(laps.start + 1, laps.stop + 1))


def _laps(laps: slice) -> Iterator[Series]:
    """Yield O's four sets; marks are filled where IPEC ran."""
    for filled in (False, True):
        for way, color, marker in _WAYS:
            errors = lap_errors_of(ROBOT, way)["OmniMate" if filled else "plain"][laps]
            last = 5 if filled or not laps.start else 4  # O drove lap 10 with IPEC only
            yield f"{way}, {'with' if filled else 'without'} IPEC", errors[:last], color, marker, filled


def draw_growth(path: Path) -> None:
    """Draw C 3.3: heading error at once, lateral error slowly, and what IPEC leaves of both."""
    growth = bump_growth()
    number = np.arange(len(growth.plain))
    with framed(path, (10.4, 5.2), 3) as figure:
        figure.suptitle("C 3.3, simulated: one 10 mm bump under a right wheel, 0.5 m/s, 20 mm per interval")
        heading, lateral = figure.subplots(1, 2)
        for axes, column, scale in ((heading, 0, np.degrees(1.0)), (lateral, 1, 1e3)):
            axes.plot(number, scale * growth.plain[:, column], "s-", color=VERMILLION, label="plain odometry")
            axes.plot(number, scale * growth.ipec[:, column], "o-", color=BLUE, label="IPEC, C (9)-(16)")
            axes.set_xlabel("sampling interval of 40 ms since the bump is met")
        seen = np.degrees(growth.seen)
        heading.plot(number, seen, "x--", color=GREEN, label="internal: seen by the linkage")
        _annotate_growth(heading, lateral, growth)


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


def draw_all(folder: Path) -> Iterator[Path]:
    """Draw all figures into a folder, which is made if need be; yield each file's path when it is written.

    PlotError: the folder or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PlotError(folder, f"cannot be made: {error.strerror}") from error
    figures: dict[str, Callable[[Path], None]] = {
        "u06-return-positions": draw_u6,
        "u11-before-and-after": draw_u11,
        "c08-straight-line": draw_c8,
        "c10-rectangle": draw_c10,
        "o05-positions-no-bumps": lambda path: draw_positions(path, 5, slice(0, 5)),
        "o06-headings-no-bumps": lambda path: draw_headings(path, 6, slice(0, 5)),
        "o07-positions-bumps": lambda path: draw_positions(path, 7, slice(5, 10)),
        "o08-headings-bumps": lambda path: draw_headings(path, 8, slice(5, 10)),
        "growth-rates": draw_growth,
    }
    for name, draw in figures.items():
        path = folder / f"{name}.png"
        draw(path)
        yield path


def draw_u6(path: Path) -> None:
    """Draw U Fig. 6: where the uncalibrated robot returns to, and the centres of gravity."""
    before, *_ = stages_of(FIGURE_11, ROBOT)
    plot_clusters([Clusters("U Fig. 6, simulated: 4 x 4 m square, uncalibrated", before)], path)


def draw_u11(path: Path) -> None:
    """Draw U Fig. 11: the same before and after the calibration."""
    before, after, _ = stages_of(FIGURE_11, ROBOT)
    plot_clusters([Clusters("U Fig. 11, simulated: UMBmark, one pass", before, after)], path)
