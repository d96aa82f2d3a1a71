"""Pictures of `tracking`: errors along each drive of a world, NEES along it, and the learned states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from studies.estimators.tracking import Row

ACROSS = 4  # panels in a row
STYLES = {
    "plain": ("0.6", 1.0),
    "IPEC": ("tab:orange", 1.0),
    "OmniMate": ("tab:green", 1.0),
    "calibrated": ("tab:blue", 1.8),
    "nominal": ("tab:red", 1.2),
}


STATES = (
    *("a.left", "a.right", "b.left", "b.right", "wheelbase a", "wheelbase b"),
    *("creep a", "creep b", "joint_a", "joint_b", "link"),
)


def draw_errors(rows: Sequence[Row], path: Path) -> None:
    """Draw the distance from the truth along each drive, one panel for each case."""
    figure, axes = _panels(rows)
    for axis, row in zip(axes, rows, strict=False):
        for name, (colour, width) in STYLES.items():
            error = 1e3 * np.hypot(row.curves[name][:, 0], row.curves[name][:, 1])
            axis.plot(row.time, np.maximum(error, 0.1), color=colour, lw=width, label=name)
        axis.set_yscale("log")
        axis.set_ylim(0.3)
    axes[0].legend(fontsize=6)
    _save(figure, path, "time [s]", "position error [mm]")


def draw_nees(rows: Sequence[Row], path: Path, limits: tuple[float, float]) -> None:
    """Draw NEES along each drive, and the limits between which it is consistent."""
    figure, axes = _panels(rows)
    for axis, row in zip(axes, rows, strict=False):
        axis.axhspan(*limits, color="tab:green", alpha=0.2, lw=0)
        axis.plot(row.time, np.maximum(row.standing, 1e-3), color="tab:blue", lw=1.0)
        axis.set_yscale("log")
        axis.set_ylim(1e-2)
    _save(figure, path, "time [s]", "NEES; green: 95 % of a chi-squared variable, 3 degrees of freedom")


def draw_states(rows: Sequence[Row], path: Path) -> None:
    """Draw what was learned of the encoders at the end of each drive, with two standard deviations."""
    figure, axes = _panels(rows)
    for axis, row in zip(axes, rows, strict=False):
        axis.errorbar(range(len(STATES)), row.slow, 2.0 * row.sigma, fmt="o", ms=3, lw=1, color="tab:blue")
        axis.axhline(0.0, color="0.7", lw=0.5)
        axis.set_xticks(range(len(STATES)), STATES, rotation=90)
        axis.set_yscale("symlog", linthresh=0.01)
        axis.margins(y=0.15)
    _save(figure, path, "", "learned, in the largest size that is expected; bars: 2 standard deviations")


def _panels(rows: Sequence[Row]) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each case, with its name above it."""
    down = -(-len(rows) // ACROSS)
    figure, grid = plt.subplots(
        down, ACROSS, figsize=(4.0 * ACROSS, 2.4 * down), squeeze=False, layout="constrained"
    )
    axes: list[Axes] = list(grid.flat)
    for axis in axes[len(rows) :]:
        axis.set_visible(False)
    for axis, row in zip(axes, rows, strict=False):
        axis.set_title(row.what[:48], fontsize=8)
        axis.tick_params(labelsize=7)
    return figure, axes


def _save(figure: Figure, path: Path, below: str, beside: str) -> None:
    figure.supylabel(beside, fontsize=9)
    figure.supxlabel(below, fontsize=9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    plt.close(figure)
