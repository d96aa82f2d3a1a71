"""The real part of the study: what the tool finds in recordings of robots whose truth is not known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from omnimate.cli.tables import new_table
from omnimate.figures.floor_plan import Track, plot_floor_plan
from omnimate.mismatch import Diagnosis, diagnose
from omnimate.mismatch.description.first_look import first_look
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import Array, wrap
from studies.datasets import husky, labyrinth
from studies.figures import plot_turns


def draw_labyrinth(described: Sequence[Recording], corrected: Sequence[Recording], folder: Path) -> None:
    """Draw the one drive as measured, and odometry as described and as corrected, each laid onto it."""
    assert described[0].poses is not None  # the importer gives them
    tracks = [
        Track("measured", described[0].poses.pose[:, :2]),
        Track("odometry as described", _laid(described[0]), dashed=True),
        Track("odometry as the first look corrects it", _laid(corrected[0]), dashed=True),
    ]
    plot_floor_plan(tracks, folder / "labyrinth.png", title="labyrinth_tuc, 30 s")


def draw_husky(described: Sequence[Recording], corrected: Sequence[Recording], folder: Path) -> None:
    """Draw the turn of every window: by the wheels of the described robot, and as measured."""
    pairs = np.array([_turned(recording) for recording in described])
    old, new = (recordings[0].vehicle.trucks["a"] for recordings in (described, corrected))
    rolls = (new.wheel_diameter_left + new.wheel_diameter_right) / (
        old.wheel_diameter_left + old.wheel_diameter_right
    )
    title, ratio = f"drive_ugv: {len(pairs)} windows of 2 s", new.wheelbase / old.wheelbase / rolls
    plot_turns(pairs[:, 0], pairs[:, 1], ratio, folder / "husky.png", title=title)


def _laid(recording: Recording) -> Array:
    """Return odometry (N, 2), turned and shifted as a whole so that it lies best on the positions [m]."""
    assert recording.poses is not None  # as above
    path = dead_reckon(recording)
    at, goal = recording.poses.time, recording.poses.pose[:, 0] + 1j * recording.poses.pose[:, 1]
    way = path[:, 0] + 1j * path[:, 1]
    seen = np.interp(at, recording.time, way.real) + 1j * np.interp(at, recording.time, way.imag)
    turn = np.vdot(seen - seen.mean(), goal - goal.mean())
    laid = (way - seen.mean()) * turn / abs(turn) + goal.mean()
    return np.stack([laid.real, laid.imag], axis=1)


def _turned(recording: Recording) -> tuple[float, float]:
    """Return how far a truck turned by its wheels, and as measured (less than half a turn) [rad]."""
    assert recording.poses is not None  # as above
    poses, path = recording.poses, dead_reckon(recording)
    first, last = np.interp(poses.time[[0, -1]], recording.time, path[:, 2])
    return float(last - first), float(wrap(poses.pose[-1, 2] - poses.pose[0, 2]))


DATA = ("labyrinth_tuc", "drive_ugv")  # the folders of the data
HUSKY_EVERY = 6  # one in so many windows is searched; the first look sees all


def real_part(folder: Path, figures: Path | None) -> Iterator[Table | str]:
    """Yield what the tool finds in the real recordings that are there, and draw it where a folder is given.

    SourceError: the data are damaged; PlotError: a figure cannot be written.
    """
    for name in DATA:
        if not (folder / name).is_dir():
            yield f"{folder / name} is not there: left out"
        else:
            yield from _robot(folder / name, figures)


def _robot(folder: Path, figures: Path | None) -> Iterator[Table | str]:
    """Yield the answers about a robot, as described and as corrected by the first look."""
    is_husky = folder.name == "drive_ugv"
    source = husky if is_husky else labyrinth
    described = [recording for _, recording in source.each_recording(folder)]
    look = first_look(described)
    corrected = described if look is None else [look.corrected(recording) for recording in described]
    table = new_table(
        f"{folder.name}: as described, and as the first look corrects it",
        ("robot", "held-out residual", "findings"),
    )
    first = diagnose(described)
    for name, diagnosis in (
        ("as described", first),
        ("corrected", diagnose(corrected[:: HUSKY_EVERY if is_husky else 1])),
    ):
        table.add_row(name, residual(diagnosis), findings(diagnosis))
    yield table
    yield first.says
    if figures is not None:
        (draw_husky if is_husky else draw_labyrinth)(described, corrected, figures)


def residual(diagnosis: Diagnosis) -> str:
    """Return the held-out residual without and with what was found."""
    fit = diagnosis.fit
    return "-" if fit is None else f"{fit.heldout.before:.2f} -> {fit.heldout.after:.2f}"


def findings(diagnosis: Diagnosis) -> str:
    """Return the first five findings with their probabilities, and what an unknown depends on."""
    shown = [
        f"{finding.effect} {finding.component} {finding.probability:.0%}"
        + (f" ({finding.where.regime})" if finding.effect == "unknown" else "")
        for finding in diagnosis.findings[:5]
    ]
    return "; ".join(shown) or diagnosis.verdict
