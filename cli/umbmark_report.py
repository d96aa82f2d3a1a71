"""What `omnimate umbmark` prints and draws of its results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from calib.experiment import experiment_of_recordings
from calib.extended import extended_umbmark
from calib.stop_rule import stop_rule
from cli.loading import load
from cli.umbmark_tables import calibration_table, errors_table, show
from cli.umbmark_words import all_passes, extended_words, say, summary
from figures.plots import Clusters

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from cli.umbmark_results import Result
    from cli.umbmark_sources import Case
    from vehicle.parameters import VehicleParameters


def report(results: Sequence[Result], e_s: float, before: VehicleParameters | None) -> None:
    """Print the tables and the sentences; `before` is the robot before its first pass."""
    cases = [one.case for one in results]
    show(errors_table(cases))
    show(calibration_table(cases, [one.calibrations for one in results]))
    for one in results:
        for line in summary(one.case, one.chosen):
            say(line)
        say(f"  {stop_rule(one.case.experiment.errors)}")
        if before is not None and one.case.truck in before.trucks:
            say(f"  {all_passes(before.trucks[one.case.truck], one.truck)}")
    if e_s != 1.0:
        say(f"E_s {e_s:.5f} by tape: wheels and wheelbase are written {e_s:.5f} times as large")


def extended(cases: Sequence[Case], folder: Path, side: float | None) -> None:
    """Print the extended UMBmark: the squares of each truck against those of a recording with bumps."""
    for case in cases:
        smooth = case.experiment.errors
        bumpy = experiment_of_recordings([load(folder)], case.truck, side).errors
        result = extended_umbmark(smooth.cw[:, 2], smooth.ccw[:, 2], bumpy.cw[:, 2], bumpy.ccw[:, 2])
        say(f"{case.label}: {extended_words(result)}")


def panel(one: Result) -> Clusters:
    """Return the return errors of one truck before and after, as they are drawn."""
    return Clusters(one.case.label, one.case.experiment.errors, one.chosen.errors)
