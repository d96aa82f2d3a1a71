"""The real part of `omnimate prove`: recordings of robots of whose physics nobody knows the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from cli.console import err, out

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from rich.console import JustifyMethod

    from calib.optiodom_sets import DriveSet
    from mismatch import Diagnosis
    from vehicle.parameters import Truck
    from vehicle.recording import Recording

HUSKY_EVERY = 6  # of the windows, where the search goes over them; the first look sees all


@dataclass(frozen=True, slots=True)
class SetRow:
    """One OptiOdom set: what each way to better numbers leaves, on drives that it has not seen.

    Attributes:
        name: path/date.
        diagnosis: of the nominal robot against its runs.
        nominal: position error of the robot as described, 10 s open loop, rms [m].
        calibrated: likewise, of the least-squares calibration on the squares of other sets.
        found: likewise, with the effects that the diagnosis fitted to the set's other runs.
    """

    name: str
    diagnosis: Diagnosis
    nominal: float
    calibrated: float
    found: float


@dataclass(frozen=True, slots=True)
class RobotRow:
    """One robot that is described wrongly: as it is described, and as the first look corrects it.

    Attributes:
        name: of the data.
        recordings: as described.
        corrected: likewise, as the first look describes them.
        first: diagnosis of the robot as described.
        second: of the corrected one.
    """

    name: str
    recordings: Sequence[Recording]
    corrected: Sequence[Recording]
    first: Diagnosis
    second: Diagnosis


def show_real(folder: Path, figures: Path | None = None) -> None:
    """Print what the tool finds in the real recordings that are there, and draw it.

    Raises:
        OptiOdomError, SourceError: data are damaged.
        PlotError: a figure cannot be written.
    """
    for name, show in (
        ("optiodom", _show_optiodom),
        ("labyrinth_tuc", _show_robot),
        ("drive_ugv", _show_robot),
    ):
        if (folder / name).is_dir():
            show(folder / name, figures)
        else:
            out.print(f"{folder / name} is not there: left out")


def optiodom_rows(folder: Path, only: str = "") -> Iterator[SetRow]:
    """Yield a row for each differential OptiOdom set whose path/date has `only` in it."""
    from calib.optiodom_sets import read_set
    from imports.optiodom import differential_sets, recordings_of
    from mismatch import diagnose
    from mismatch.rerun import open_loop

    sets, _ = differential_sets(folder)
    data = {one: read_set(one) for one in sets}
    trucks: dict[str, Truck] = {}
    for one in sets:
        name = f"{one.parent.name}/{one.name}"
        if only not in name:
            continue
        left_out = name if data[one].path == "square" else ""
        if left_out not in trucks:
            trucks[left_out] = _calibrated(
                [it for key, it in data.items() if key.name != one.name or not left_out]
            )
        recordings = recordings_of(one)
        diagnosis = diagnose(recordings)
        assert diagnosis.fit is not None  # every set has poses and minutes of driving
        loop = diagnosis.fit.rerun["a position"]
        better = [replace(it, vehicle=it.vehicle.with_truck("a", trucks[left_out])) for it in recordings]
        yield SetRow(name, diagnosis, loop.before, open_loop(better)["a position"], loop.after)


def _calibrated(sets: Sequence[DriveSet]) -> Truck:
    """Return the truck of the least-squares calibration on the squares among sets."""
    from calib.kinematics import Differential
    from calib.optiodom_score import calibrate_squares

    kinematics = calibrate_squares(sets).kinematics
    assert isinstance(kinematics, Differential)  # as all of the sets are
    return kinematics.truck


def robot_row(folder: Path, every: int = 1) -> RobotRow:
    """Return the answers to labyrinth_tuc or drive_ugv, as described and as corrected by the first look.

    Args:
        folder: of the data.
        every: of the corrected recordings is searched.

    Raises:
        SourceError: data are damaged.
    """
    from imports import husky, labyrinth
    from mismatch import diagnose
    from mismatch.first_look import first_look

    source = labyrinth if folder.name == "labyrinth_tuc" else husky
    recordings = source.recordings_of(folder)
    look = first_look(recordings)
    corrected = recordings if look is None else [look.corrected(one) for one in recordings]
    return RobotRow(folder.name, recordings, corrected, diagnose(recordings), diagnose(corrected[::every]))


def _show_optiodom(folder: Path, figures: Path | None) -> None:
    table = Table(title="OptiOdom: the nominal robot against its recordings, every set on its own")
    headings: dict[str, JustifyMethod] = {
        "set": "left",
        "held-out\nresidual": "left",
        "position, 10 s\nnominal [mm]": "right",
        "\ncalibrated": "right",
        "\nfound effects": "right",
        "first findings": "left",
    }
    for heading, justify in headings.items():
        table.add_column(heading, justify=justify)
    with Progress(console=err, transient=True) as progress:
        rows = list(progress.track(optiodom_rows(folder), description="OptiOdom"))
    for row in rows:
        errors = (f"{1e3 * one:.1f}" for one in (row.nominal, row.calibrated, row.found))
        table.add_row(Text(row.name), residual(row.diagnosis), *errors, findings(row.diagnosis))
    out.print(table)
    if figures is not None:
        from figures.real import plot_errors

        names = [row.name for row in rows]
        columns = {
            "nominal": [row.nominal for row in rows],
            "calibrated on squares of other sets": [row.calibrated for row in rows],
            "with the effects found": [row.found for row in rows],
        }
        plot_errors(names, columns, figures / "optiodom.png")


def _show_robot(folder: Path, figures: Path | None) -> None:
    husky = folder.name == "drive_ugv"
    row = robot_row(folder, HUSKY_EVERY if husky else 1)
    table = Table(title=f"{row.name}: as described, and as the first look corrects it")
    for heading in ("robot", "held-out residual", "findings"):
        table.add_column(heading)
    table.add_row("as described", residual(row.first), findings(row.first, 5))
    table.add_row("corrected", residual(row.second), findings(row.second, 5))
    out.print(table)
    out.print(row.first.says, soft_wrap=True)
    if figures is not None:
        from cli.prove_figures import draw_husky, draw_labyrinth

        (draw_husky if husky else draw_labyrinth)(row, figures)


def residual(diagnosis: Diagnosis) -> str:
    """Return the held-out residual without and with what was found."""
    fit = diagnosis.fit
    return "-" if fit is None else f"{fit.heldout.before:.2f} -> {fit.heldout.after:.2f}"


def findings(diagnosis: Diagnosis, most: int = 3) -> str:
    """Return the first findings with their probabilities, and what an unknown depends on."""
    shown = [
        f"{one.effect} {one.component} {one.probability:.0%}"
        + (f" ({one.where.regime})" if one.effect == "unknown" else "")
        for one in diagnosis.findings[:most]
    ]
    return "; ".join(shown) or diagnosis.verdict
