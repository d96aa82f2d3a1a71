"""What the demo shows in the end: the return errors before and after, and where the robot went."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from omnimate.cli.console import warn
from omnimate.figures.clusters import Clusters, plot_clusters
from omnimate.figures.floor_plan import Track, plot_floor_plan
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.calib.umbmark.experiment import Calibration
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


def result_table(
    before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], truth: Truth
) -> Table:
    """Return the table of E_max,syst before and after, and of what was found beside what is true."""
    table = Table(title="UMBmark before and after: millimetres", title_justify="left")
    for head in ("truck", "E_max,syst before", "after", "better by", "wheelbase nominal", "found", "true"):
        table.add_column(head, justify="right")
    table.add_column("D_R/D_L found", justify="right")
    table.add_column("true", justify="right")
    for truck, calibration in before.items():
        first, second = calibration.experiment.errors.e_max_syst, after[truck].experiment.errors.e_max_syst
        fitted, true = calibration.truck, truth.vehicle.trucks[truck]
        table.add_row(
            truck,
            f"{1e3 * first:.0f}",
            f"{1e3 * second:.0f}",
            f"{first / second:.1f}-fold",
            f"{1e3 * calibration.experiment.truck.wheelbase:.2f}",
            f"{1e3 * fitted.wheelbase:.2f}",
            f"{1e3 * true.wheelbase:.2f}",
            f"{fitted.wheel_diameter_right / fitted.wheel_diameter_left:.5f}",
            f"{true.wheel_diameter_right / true.wheel_diameter_left:.5f}",
        )
    return table


def draw_clusters(
    before: dict[TruckName, Calibration], after: dict[TruckName, Calibration], path: Path
) -> None:
    """Draw the return errors before and after, as U Fig. 11."""
    plot_clusters(
        [
            Clusters(f"truck {truck}", before[truck].experiment.errors, after[truck].experiment.errors)
            for truck in before
        ],
        path,
    )


def draw_paths(recording: Recording, true_path: Array, path: Path) -> None:
    """Draw the first square each way: the true path, and odometry's from the fix at each lap's start."""
    if recording.run is None or recording.poses is None or len(true_path) == 0:
        warn("no lap was driven to its end; no path is drawn")
        return
    fixes = recording.poses.of("a")
    pose = dead_reckon(recording, "a")
    tracks = [Track("truck a, true", true_path)]
    for lap in recording.run.laps[:2]:
        driven = pose[recording.between(lap.start, lap.end)]
        fix = fixes.pose[np.searchsorted(fixes.time, lap.start, side="right") - 1]
        tracks.append(
            Track(f"truck a by odometry, {lap.direction}", compose(fix, between(driven[0], driven)))
        )
    plot_floor_plan(tracks, path, title="before calibration", fixes=fixes.pose[:4])
