"""What `omnimate umbmark` prints and draws of its results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.calib.umbmark.extended import extended_umbmark
from omnimate.calib.umbmark.stop_rule import stop_rule
from omnimate.cli.loading import load
from omnimate.cli.tables import show
from omnimate.cli.umbmark.sentences import all_passes, extended_words, say, summary
from omnimate.cli.umbmark.tables import calibration_table, errors_table

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.cli.umbmark.results import Result
    from omnimate.cli.umbmark.sources import Case
    from omnimate.vehicle.parameters import VehicleParameters


def report(results: Sequence[Result], e_s: float, before: VehicleParameters | None) -> None:
    """Print the tables and the sentences; `before` is the robot before its first pass."""
    cases = [result.case for result in results]
    show(errors_table(cases))
    show(calibration_table(cases, [result.assessment.calibrations for result in results]))
    for result in results:
        for line in summary(result.case, result.chosen):
            say(line)
        say(f"  {stop_rule(result.case.experiment.errors)}")
        if before is not None and result.case.truck in before.trucks:
            say(f"  {all_passes(before.trucks[result.case.truck], result.truck)}")
    if e_s != 1.0:
        say(f"E_s {e_s:.5f} by tape: wheels and wheelbase are written {e_s:.5f} times as large")


def extended(cases: Sequence[Case], folder: Path, side: float | None) -> None:
    """Print the extended UMBmark: the squares of each truck against those of a recording with bumps."""
    for case in cases:
        smooth = case.experiment.errors
        bumpy = experiment_of_recordings([load(folder)], case.truck, side).errors
        result = extended_umbmark(smooth.cw[:, 2], smooth.ccw[:, 2], bumpy.cw[:, 2], bumpy.ccw[:, 2])
        say(f"{case.label}: {extended_words(result)}")


def draw(results: Sequence[Result], path: Path) -> None:
    """Draw the return errors of each truck before and after its calibration, as U Fig. 11.

    Raises:
        PlotError: The file cannot be written.
    """
    from omnimate.figures.clusters import Clusters, plot_clusters

    panels = [
        Clusters(result.case.label, result.case.experiment.errors, result.chosen.errors) for result in results
    ]
    plot_clusters(panels, path)
    say(f"figure: {path}")
