"""`omnimate calibrate`: any drive with absolute poses, or a linkage -> better parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cli.calibrate_tables import factors_table, noise_sentences, quantities_table, scores_table
from cli.choices import TruckChoice
from cli.console import out, warn
from cli.umbmark_tables import show

if TYPE_CHECKING:
    from calib.estimates import Estimate
    from calib.least_squares import PathCalibration, Quantity
    from vehicle.parameters import TruckName
    from vehicle.recording import Recording


@dataclass(frozen=True, slots=True)
class Options:
    """What to estimate beside the truck, and what not.

    Attributes:
        reference_offset: where the reference sits on the truck.
        time_offset: the delay of its clock.
        hold: coordinates that stay nominal.
        spacing: between absolute poses that are used [s].
    """

    reference_offset: bool
    time_offset: bool
    hold: tuple[str, ...]
    spacing: float


def calibrate(
    sources: Annotated[
        list[Path] | None, typer.Argument(help="Recording folders of one robot.", exists=True)
    ] = None,
    truck: Annotated[
        TruckChoice | None, typer.Option(help="Calibrate this truck only; else each one that has poses.")
    ] = None,
    reference_offset: Annotated[
        bool, typer.Option("--reference-offset", help="Estimate where the reference sits on the truck.")
    ] = False,
    time_offset: Annotated[
        bool, typer.Option("--time-offset", help="Estimate the delay of the reference's clock.")
    ] = False,
    linkage: Annotated[
        bool, typer.Option("--linkage", help="Calibrate joint and link biases too; drive with turns.")
    ] = False,
    hold: Annotated[
        list[str] | None, typer.Option(help="Keep this coordinate nominal; may be repeated.")
    ] = None,
    spacing: Annotated[
        float, typer.Option(help="Between absolute poses that are used [s]; 0 takes all.", min=0.0)
    ] = 2.0,
    out_file: Annotated[
        Path | None, typer.Option("--out", help="Write the calibrated vehicle.toml here.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the first drive before and after: .png, .svg or .pdf.")
    ] = None,
    profile: Annotated[
        tuple[Path, str] | None, typer.Option(help="FILE NAME: keep the trucks there under this name.")
    ] = None,
    optiodom: Annotated[
        Path | None,
        typer.Option(help="Root of the OptiOdom data: calibrate on its squares, score on all.", exists=True),
    ] = None,
) -> None:
    """Calibrate from any drive with absolute poses, by least squares; or a linkage from its own readings."""
    if optiodom is not None:
        _score(optiodom)
    if not sources:
        if optiodom is None:
            raise typer.BadParameter("give recording folders, or --optiodom ROOT")
        return
    from calib.channel_guards import frozen_linkage
    from figures.plots import check_format
    from vehicle.folder import load_recording

    if plot is not None:
        check_format(plot)
    recordings = [load_recording(source) for source in sources]
    for one in [] if linkage else [advice for it in recordings for advice in frozen_linkage(it)]:
        warn(f"{one}; the trucks are calibrated without it")
    choice: TruckName | None = truck.value if truck is not None else None
    options = Options(reference_offset, time_offset, tuple(hold or ()), spacing)
    names = _trucks(recordings, choice, linkage=linkage)
    found = {name: _truck(recordings, name, options) for name in names}
    if linkage:
        _linkage(recordings, found, out_file)
    elif out_file is not None:
        _write(recordings[0], found, out_file)
    if profile is not None:
        _keep(found, *profile)
    if plot is not None:
        _draw(recordings[0], found, plot)


def _trucks(recordings: list[Recording], choice: TruckName | None, *, linkage: bool) -> list[TruckName]:
    """Return the truck asked for, or those with two poses or more; a linkage can do without any."""
    if choice is not None:
        return [choice]
    known: list[TruckName] = []
    for name in recordings[0].vehicle.trucks:
        poses = [one.poses.of(name) for one in recordings if one.poses is not None]
        if any(len(one.time) > 1 for one in poses):
            known.append(name)
    return known if known or linkage else ["a"]


def _truck(recordings: list[Recording], name: TruckName, options: Options) -> PathCalibration:
    from calib.least_squares import calibrate_truck

    found = calibrate_truck(
        recordings,
        name,
        with_offset=options.reference_offset,
        with_time=options.time_offset,
        hold=options.hold,
        spacing=options.spacing,
    )
    _print(f"Truck {name}, {found.source}", found.quantities, found.estimate)
    return found


def _linkage(
    recordings: list[Recording], trucks: dict[TruckName, PathCalibration], out_file: Path | None
) -> None:
    from calib.linkage_calibration import calibrate_linkage, corrected_linkage
    from vehicle.file import save_vehicle

    found = calibrate_linkage(recordings, trucks=trucks)
    _print(f"Linkage, {found.source}", found.quantities, found.estimate)
    if out_file is not None:
        save_vehicle(corrected_linkage(recordings[0].vehicle, found), out_file)
        out.print(f"calibrated: {out_file}", soft_wrap=True)


def _print(title: str, quantities: tuple[Quantity, ...], estimate: Estimate) -> None:
    show(quantities_table(title, quantities))
    show(factors_table(estimate))
    for sentence in noise_sentences(estimate):
        out.print(sentence, soft_wrap=True)


def _write(recording: Recording, found: dict[TruckName, PathCalibration], path: Path) -> None:
    from calib.apply import corrected_vehicle
    from vehicle.file import save_vehicle

    trucks = {name: one.truck for name, one in found.items()}
    save_vehicle(corrected_vehicle(recording.vehicle, trucks), path)
    out.print(f"calibrated: {path}", soft_wrap=True)


def _keep(found: dict[TruckName, PathCalibration], path: Path, name: str) -> None:
    from calib.profiles import save_profile

    save_profile(path, name, {truck: one.truck for truck, one in found.items()})
    out.print(f"profile {name}: {path}", soft_wrap=True)


def _draw(recording: Recording, found: dict[TruckName, PathCalibration], path: Path) -> None:
    """Draw the first drive of the first truck, from its first pose."""
    from calib.drives import drives_of
    from calib.kinematics import Differential
    from calib.reference import dead_reckoned
    from figures.plots import Track, plot_floor_plan

    name, calibration = next(iter(found.items()))
    drive = drives_of([recording], name)[0]
    before = dead_reckoned(drive, Differential(recording.vehicle.trucks[name]))
    after = dead_reckoned(drive, calibration.kinematics)
    tracks = [Track("odometry before", before), Track("odometry calibrated", after, dashed=True)]
    plot_floor_plan(tracks, path, title=f"truck {name}", fixes=drive.pose)
    out.print(f"figure: {path}", soft_wrap=True)


def _score(root: Path) -> None:
    from calib.optiodom_score import score_optiodom

    for robot in score_optiodom(root):
        _print(f"{robot.kind}, all squares", robot.calibration.quantities, robot.calibration.estimate)
        show(scores_table(robot))
