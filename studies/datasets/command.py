"""The public data sets on the command line: as recordings, calibrated, and by UMBmark."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.progress import track
from rich.table import Table
from rich.text import Text

from omnimate.cli.calibrate import print_estimate
from omnimate.cli.console import err, out, warn
from omnimate.cli.options import MethodChoice
from omnimate.cli.tables import new_table, show
from omnimate.cli.umbmark.calibration import Case, print_advice, result_of
from omnimate.cli.umbmark.report import draw, report
from omnimate.files.importers.sanity import odometry_error
from omnimate.files.recordings.folder import save_recording
from omnimate.vehicle.recording import Recording
from studies.datasets import husky as husky_data
from studies.datasets import labyrinth as labyrinth_data
from studies.datasets.optiodom.drives import differential_sets, each_recording
from studies.datasets.optiodom.scores import RobotScores, Score, experiment_of_optiodom, score_optiodom

Out = Annotated[Path, typer.Argument(help="Folder to write the recording folders into.")]
importers = typer.Typer(help="Make recording folders of a public data set.", no_args_is_help=True)


@importers.command()
def optiodom(
    source: Annotated[Path, typer.Argument(help="A set, or a folder of sets, of the differential robot.")],
    to: Out,
) -> None:
    """Take the runs of OptiOdom's differential robot: dense poses, one recording folder each."""
    save_set(each_recording(source), to)
    others = differential_sets(source)[1]
    if others:
        warn(
            f"{len(others)} set(s) of the tricycle left out: recording folders hold differential drives only"
        )


@importers.command()
def labyrinth(
    source: Annotated[Path, typer.Argument(help="Folder with Indoor_UWB_Input.txt and Indoor_UWB_GT.txt.")],
    to: Out,
) -> None:
    """Take the drive of TU Chemnitz's Labyrinth as its readme describes it, which is known to be wrong."""
    save_set(labyrinth_data.each_recording(source), to)


@importers.command()
def husky(
    source: Annotated[Path, typer.Argument(help="Folder with husky_windows.npz.")],
    to: Out,
) -> None:
    """Take the DRIVE data of a Clearpath Husky: a recording folder for each window of two seconds."""
    save_set(husky_data.each_recording(source), to)


def umbmark(
    sources: Annotated[list[Path], typer.Argument(help="OptiOdom sets of squares.", exists=True)],
    side: Annotated[float | None, typer.Option(help="Side of the square [m], if not the metadata's.")] = None,
    method: Annotated[MethodChoice, typer.Option(help="Method whose result --plot takes.")] = "exact",
    plot: Annotated[
        Path | None, typer.Option(help="Draw the return errors before and after: .png, .svg or .pdf.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Use a result that the checks refuse.")] = False,
) -> None:
    """Calibrate OptiOdom's differential robot by UMBmark from its sets of squares."""
    cases = [Case(source.resolve().name, "a", experiment_of_optiodom(source, side)) for source in sources]
    results = [result_of(case, method, 1.0) for case in cases]
    report(results, 1.0, None)
    print_advice(results, force=force)
    if plot is not None:
        draw(results, plot)


def calibrate(
    root: Annotated[Path, typer.Argument(help="Root of the OptiOdom data.", exists=True)],
) -> None:
    """Calibrate OptiOdom's robots on their squares by least squares, and score them on all sets."""
    for robot in score_optiodom(root):
        print_estimate(f"{robot.kind}, all squares", robot.calibration.quantities, robot.calibration.estimate)
        for advice in robot.calibration.left_out:
            warn(str(advice))
        show(_scores_table(robot))


def save_set(recordings: Iterable[tuple[str, Recording]], to: Path) -> None:
    """Write many recordings, and say how far the odometry of all of them is off."""
    samples, errors = [], []
    for name, recording in track(recordings, "importing", console=err, transient=True):
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        save_recording(recording, to / name)
        samples.append(len(recording))
        errors.append(odometry_error(recording))
    out.print(f"{len(samples)} recording(s), {sum(samples)} samples in {to}", soft_wrap=True)
    known = np.array([error for error in errors if error is not None])
    if len(known):
        position, heading = np.sqrt(np.mean(known[:, 1:] ** 2, axis=0))
        out.print(
            f"nominal odometry ends {1e3 * position:.1f} mm and {math.degrees(heading):.2f} deg from "
            f"the last pose (root mean square), after {known[:, 0].mean():.2f} m on average",
            soft_wrap=True,
        )


def _scores_table(robot: RobotScores) -> Table:
    """Return the scores of one OptiOdom robot on all sets: final / rms distance."""
    heads = (
        "runs",
        "raw\nfinal, rms",
        "printed UMBmark\nfinal, rms",
        "least squares\nfinal, rms",
        "and markers\nplaced",
    )
    table = new_table(
        f"{robot.kind}: dead reckoning against motion capture, millimetres; calibrated on the squares",
        ("set", "calibration"),
        heads,
    )
    for drives in robot.sets:
        seen = "has seen it" if drives.seen else "held out"
        scores = (_score(score) for score in (drives.raw, drives.printed, drives.fitted, drives.placed))
        table.add_row(Text(drives.name), seen, str(drives.runs), *scores)
    return table


def _score(score: Score | None) -> str:
    return "-" if score is None else f"{1e3 * score.final:.1f}, {1e3 * score.rms:.1f}"
