"""`omnimate export`: a recording or a log in the formats of other tools; `omnimate dbc`: a vehicle's DBC."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import note, out, progress_bar, report_problem, say, warn
from omnimate.cli.descriptions import vehicle_of
from omnimate.cli.errors import CallError
from omnimate.cli.loading import log_of, read_drive, report_problems
from omnimate.cli.options import LogSource, check_out_file

if TYPE_CHECKING:
    from omnimate.files.exporters.drive import Drive
    from omnimate.files.exporters.export import Exported
    from omnimate.files.logs.blocks import LogStream


def export(
    source: LogSource,
    to: Annotated[
        Path,
        typer.Argument(
            help="File to write: .mcap, .parquet, .tum, .pcap, .pcapng, .blf, .asc, .csv, .log, .log.gz; "
            "a name without suffix is a ROS 2 bag."
        ),
    ],
    vehicle: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            help="vehicle.toml: a log's odometry is computed too; a recording folder has its own.",
        ),
    ] = None,
    frames: Annotated[
        bool, typer.Option("--frames", help="Write a drive's CAN frames too (.mcap, .parquet, a bag).")
    ] = False,
) -> None:
    """Write a recording or a log for Foxglove, PlotJuggler, ROS 2, evo, Wireshark, pandas."""
    from omnimate.files.errors import ExportError
    from omnimate.files.exporters.export import DRIVE_SUFFIXES, export_drive, export_frames, suffix_of
    from omnimate.files.logs.blocks import LogStream

    suffix = suffix_of(to)  # names a missing extra before anything is computed
    path = log_of(source)
    if to.exists() and path.samefile(to):
        raise CallError(f"{to}: is the log that is read; choose another file")
    log = LogStream(path)
    try:
        with progress_bar("writing") as watch:
            if suffix in DRIVE_SUFFIXES and (source.is_dir() or vehicle is not None):
                done = export_drive(_drive(source, vehicle), to, watch, log if frames else None)
            else:
                done = export_frames(log, to, watch)
    except OSError as error:
        raise ExportError(to, f"cannot be written: {error.strerror or error}") from error
    _report(log, done)


def dbc(
    vehicle: Annotated[Path, typer.Argument(exists=True, help="vehicle.toml of the robot.")],
    out_file: Annotated[
        Path, typer.Argument(metavar="OUT.dbc", callback=check_out_file, help="DBC file to write.")
    ],
) -> None:
    """Write a DBC file with which other tools decode the same values."""
    from omnimate.files.logs.dbc import dbc_of_vehicle
    from omnimate.vehicle.atomic import write_text
    from omnimate.vehicle.file import load_vehicle

    write_text(out_file, dbc_of_vehicle(load_vehicle(vehicle)))
    note(f"written: {out_file}")


def _drive(source: Path, vehicle: Path | None) -> Drive:
    """Return the drive in a folder or a log, after reporting what could not be read."""
    from omnimate.files.exporters.drive import drive_of

    loaded = read_drive(source, vehicle_of(vehicle))
    drive = drive_of(loaded.recording, loaded.log.frames)
    for remark in drive.notes:
        warn(remark)
    return drive


def _report(log: LogStream, done: Exported) -> None:
    """Say what was written, and what was left out."""
    report_problems(log)
    for reason, count in done.left_out.items():
        report_problem(f"{count} frames left out: {reason}")
    if done.frames:
        out.print(f"{done.frames} frames")
    for path in done.files:
        say(f"written: {path}")
