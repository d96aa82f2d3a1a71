"""`omnimate calibrate`: any drive with absolute poses, or a linkage -> better parameters."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import out, say, warn
from omnimate.cli.errors import CallError
from omnimate.cli.loading import load
from omnimate.cli.options import OneTruck, OutFile, Profile, written_at_end
from omnimate.cli.robots import write_profile, write_vehicle
from omnimate.cli.tables import new_table, show

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from omnimate.calib.estimation.chains import Coordinate
    from omnimate.calib.estimation.estimates import DownWeighted, Estimate
    from omnimate.calib.paths.least_squares import PathCalibration, Quantity
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

_SCREEN = {"1": ("%", 1e2), "rad": ("deg", math.degrees(1.0)), "m": ("mm", 1e3), "s": ("ms", 1e3)}
_MAX_LISTED = 5  # fixes that are listed one by one


def calibrate(
    sources: Annotated[list[Path], typer.Argument(help="Recording folders of one robot.", exists=True)],
    truck: OneTruck = None,
    reference_offset: Annotated[
        bool, typer.Option("--reference-offset", help="Estimate where the reference sits on the truck.")
    ] = False,
    time_offset: Annotated[
        bool, typer.Option("--time-offset", help="Estimate how far the reference's clock is behind.")
    ] = False,
    linkage: Annotated[
        bool, typer.Option("--linkage", help="Calibrate joint and link biases too; drive with turns.")
    ] = False,
    relative: Annotated[
        Path | None,
        typer.Option(
            help="Relative poses of a sensor (CSV), as of scan matching: calibrate by them, with its place.",
            exists=True,
        ),
    ] = None,
    hold: Annotated[
        list[str] | None, typer.Option(help="Keep this coordinate nominal; may be repeated.")
    ] = None,
    spacing: Annotated[
        float, typer.Option(help="Time between absolute poses that are used [s]; 0 takes all.", min=0.0)
    ] = 2.0,
    out_file: OutFile = None,
    plot: Annotated[
        Path | None, written_at_end("Draw the first drive before and after: .png, .svg or .pdf.")
    ] = None,
    profile: Profile = None,
) -> None:
    """In place of umbmark: calibrate from any drive whose absolute poses are measured."""
    from omnimate.calib.apply import corrected_vehicle
    from omnimate.calib.paths.least_squares import calibrate_truck
    from omnimate.figures.files import check_format

    if relative is not None:
        _relative([load(source) for source in sources], relative, truck, out_file)
        return
    if plot is not None:
        check_format(plot)
    recordings = [load(source) for source in sources]
    if not linkage:
        _warn_of_frozen(recordings)
    fits: dict[TruckName, PathCalibration] = {}
    names = _trucks(recordings, truck, linkage=linkage)
    if plot is not None and not names:
        raise CallError("--plot draws calibrated trucks, and no truck has two absolute poses; leave it out")
    for name in names:
        fit = fits[name] = calibrate_truck(
            recordings,
            name,
            with_offset=reference_offset,
            with_time=time_offset,
            hold=tuple(hold or ()),
            spacing=spacing,
        )
        print_estimate(f"Truck {name}, {fit.source}", fit.quantities, fit.estimate)
        for advice in fit.left_out:
            warn(str(advice))
    trucks = {name: fit.truck for name, fit in fits.items()}
    if linkage:
        _linkage(recordings, fits, out_file)
    else:
        write_vehicle(corrected_vehicle(recordings[0].vehicle, trucks), out_file, "calibrated")
    write_profile(profile, trucks)
    if plot is not None:
        _draw(recordings[0], fits, plot)


def _relative(
    recordings: list[Recording], path: Path, choice: TruckName | None, out_file: Path | None
) -> None:
    """Calibrate one truck, and where a sensor sits on it, by relative poses."""
    from omnimate.calib.apply import corrected_vehicle
    from omnimate.calib.relative.calibration import calibrate_relative
    from omnimate.calib.relative.motions import load_motions

    if len(recordings) != 1:
        raise typer.BadParameter("--relative needs one recording, whose clock its file shares")
    name: TruckName = choice or "a"
    found = calibrate_relative(recordings[0], load_motions(path), name)
    print_estimate(f"Truck {name} and its sensor, {found.source}", found.quantities, found.estimate)
    if found.missing_motion is not None:
        warn(found.missing_motion)
    if found.outlying:
        out.print(f"{found.outlying} of {found.estimate.fixes} relative poses contradict the others")
    write_vehicle(corrected_vehicle(recordings[0].vehicle, {name: found.truck}), out_file, "calibrated")


def _warn_of_frozen(recordings: list[Recording]) -> None:
    from omnimate.calib.recordings import frozen_linkage

    for recording in recordings:
        for advice in frozen_linkage(recording):
            warn(f"{advice}; the trucks are calibrated without it")


def _trucks(recordings: list[Recording], choice: TruckName | None, *, linkage: bool) -> list[TruckName]:
    """Return the truck asked for, or those with two poses or more; a linkage can do without any."""
    if choice is not None:
        return [choice]
    known: list[TruckName] = []
    for name in recordings[0].vehicle.trucks:
        poses = [recording.poses.of(name) for recording in recordings if recording.poses is not None]
        if any(len(fixes.time) > 1 for fixes in poses):
            known.append(name)
    return known if known or linkage else ["a"]


def _linkage(
    recordings: list[Recording], trucks: dict[TruckName, PathCalibration], out_file: Path | None
) -> None:
    from omnimate.calib.linkage.calibration import calibrate_linkage, corrected_linkage

    calibration = calibrate_linkage(recordings, trucks=trucks)
    print_estimate(f"Linkage, {calibration.source}", calibration.quantities, calibration.estimate)
    write_vehicle(corrected_linkage(recordings[0].vehicle, calibration), out_file, "calibrated")


def print_estimate(title: str, quantities: tuple[Quantity, ...], estimate: Estimate) -> None:
    """Print parameters before and after a fit, its coordinates and its noise."""
    show(quantities_table(title, quantities))
    show(factors_table(estimate))
    for sentence in noise_sentences(estimate):
        say(sentence)


def _draw(recording: Recording, calibrations: dict[TruckName, PathCalibration], path: Path) -> None:
    """Draw the first drive of each truck, from its first pose."""
    import numpy as np

    from omnimate.calib.paths.drives import drives_of
    from omnimate.calib.paths.kinematics import Differential
    from omnimate.calib.paths.reference import dead_reckoned
    from omnimate.figures.floor_plan import Track, plot_floor_plan

    tracks: list[Track] = []
    fixes: list[Array] = []
    for name, calibration in calibrations.items():
        drive = drives_of([recording], name)[0]
        before = dead_reckoned(drive, Differential(recording.vehicle.trucks[name]))
        after = dead_reckoned(drive, calibration.kinematics)
        tracks.append(Track(f"truck {name}, odometry before", before))
        tracks.append(Track(f"truck {name}, calibrated", after, dashed=True))
        fixes.append(drive.pose)
    plot_floor_plan(tracks, path, title=recording.vehicle.name, fixes=np.vstack(fixes))
    say(f"figure: {path}")


def quantities_table(title: str, quantities: Sequence[Quantity]) -> Table:
    """Return parameters before and after, with their bound and interval."""
    heads = ("unit", "nominal", "calibrated", "sigma\n(Cramer-Rao)", "95 % from", "to")
    table = new_table(title, ("parameter",), heads)
    for quantity in quantities:
        unit, scale = screen_unit(quantity.name)
        numbers = (quantity.nominal, quantity.value, quantity.sigma, quantity.low, quantity.high)
        cells = ("-" if math.isnan(number) else f"{scale * number:.4f}" for number in numbers)
        table.add_row(quantity.name, unit, *cells)
    return table


def screen_unit(name: str) -> tuple[str, float]:
    """Return the unit in which a quantity is shown, and what it is times from SI."""
    if name.endswith(("yaw", "offset")) or name.startswith("joint"):
        return "deg", math.degrees(1.0)
    return ("ms", 1e3) if name.endswith("time") else ("mm", 1e3)


def factors_table(estimate: Estimate) -> Table:
    """Return the coordinates of the fit: prior, bound, and which are held."""
    table = new_table(
        "Estimated coordinates", ("coordinate",), ("change", "bound", "known without\na drive", "")
    )
    held = {parameter.name: parameter.reason for parameter in estimate.held}
    for parameter, change, sigma in zip(
        estimate.parameters, estimate.coordinates, estimate.sigma, strict=True
    ):
        reason = f"held: {held[parameter.name]}" if parameter.name in held else ""
        bound = "-" if parameter.name in held else _size(parameter, sigma)
        sizes = _size(parameter, change, sign=True), bound, _size(parameter, parameter.prior_sigma)
        table.add_row(parameter.name, *sizes, reason)
    return table


def noise_sentences(estimate: Estimate) -> list[str]:
    """Return what the fit says about its noise, its conditioning and the fixes that it down-weighted."""
    noises = [
        f"{noise.source.name} {noise.value:.3g} {noise.source.unit} ({_origin(noise.freedom)})"
        for noise in estimate.noises
        if noise.freedom > 0.0 or noise.source.name == "roughness"
    ]
    known = f"condition number {estimate.condition:.3g} of the information on what was estimated"
    bad = estimate.down_weighted
    sentences = ["noise: " + "; ".join(noises)] if noises else []
    sentences += [
        f"{known}; {estimate.fixes} absolute poses or readings, whitened residual {estimate.rms:.2f}",
    ]
    sentences += [_in_words(fix) for fix in bad[:_MAX_LISTED]]
    if len(bad) > _MAX_LISTED:
        sentences.append(f"down-weighted: {len(bad) - _MAX_LISTED} more")
    return sentences


def _origin(freedom: float) -> str:
    return f"estimated, {freedom:.0f} degrees of freedom" if freedom > 0.0 else "assumed"


def _in_words(fix: DownWeighted) -> str:
    far = f"{fix.distance:.1f} sigma from the prediction by all others, weight {fix.weight:.2g}"
    return f"down-weighted: {fix.source}, {fix.time:.3f} s: {far}"


def _size(parameter: Coordinate, value: float, *, sign: bool = False) -> str:
    unit, scale = _SCREEN[parameter.unit]
    number = f"{scale * value:+.4f}" if sign else f"{scale * value:.4f}"
    return f"{number} {unit}"
