"""Pictures of `tracking`: the error of each method along each drive of a world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from omnimate.vehicle.se2 import Array

ACROSS = 4  # panels in a row
STYLES = {
    "plain": ("0.6", 1.0),
    "IPEC": ("tab:orange", 1.0),
    "OmniMate": ("tab:green", 1.0),
    "calibrated": ("tab:blue", 1.8),
    "nominal": ("tab:red", 1.2),
}


class Drawn(Protocol):
    """What is drawn of a case: its name, the errors of each method, and when they were judged."""

    what: str
    curves: Mapping[str, Array]
    time: Array


def draw(rows: Sequence[Drawn], path: Path) -> Path:
    """Draw the distance from the truth along each drive, one panel for each case; return where."""
    down = -(-len(rows) // ACROSS)
    figure, axes = plt.subplots(down, ACROSS, figsize=(4.0 * ACROSS, 2.4 * down), squeeze=False)
    for axis in axes.flat[len(rows) :]:
        axis.set_visible(False)
    for axis, row in zip(axes.flat, rows, strict=False):
        for name, (colour, width) in STYLES.items():
            error = 1e3 * np.hypot(row.curves[name][:, 0], row.curves[name][:, 1])
            axis.plot(row.time, np.maximum(error, 0.1), color=colour, lw=width, label=name)
        axis.set_yscale("log")
        axis.set_ylim(0.3)
        axis.set_title(row.what[:48], fontsize=8)
        axis.tick_params(labelsize=7)
    axes.flat[0].legend(fontsize=6)
    figure.supylabel("position error [mm]", fontsize=9)
    figure.supxlabel("time [s]", fontsize=9)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80)
    plt.close(figure)
    return path
