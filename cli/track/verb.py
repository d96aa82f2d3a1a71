"""`omnimate track`: plain odometry, IPEC and the filter side by side, live from a bus or over a recording."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, note
from omnimate.cli.errors import CallError
from omnimate.cli.following import open_reader
from omnimate.cli.options import ListenOnly, written_at_end
from omnimate.cli.track.live import RowWriter, follow_robot, open_rows
from omnimate.cli.track.words import disturbance_in_words, show_summary

if TYPE_CHECKING:
    from omnimate.ipec.filter.prior import Prior
    from omnimate.ipec.tracker import Learned, OneTruckTracker, Tracker


def track(
    recording: Annotated[
        Path | None,
        typer.Argument(exists=True, help="Recording folder; else the robot on --bus is followed."),
    ] = None,
    bus: Annotated[
        str | None,
        typer.Option(help="socketcan://can0, socketcand://host:port/can0, pcan://PCAN_USBBUS1, or another."),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(exists=True, help="vehicle.toml of the robot on the bus; else the reference robot."),
    ] = None,
    listen_only: ListenOnly = False,
    seconds: Annotated[
        float | None, typer.Option(help="End after so many seconds; else at Ctrl-C.", min=0.1)
    ] = None,
    uncalibrated: Annotated[
        bool,
        typer.Option(
            "--uncalibrated",
            help="vehicle.toml holds nominal values: the filter expects more of them to be wrong.",
        ),
    ] = False,
    fixes: Annotated[
        bool,
        typer.Option(
            "--fixes", help="The filter uses the absolute poses of the recording, and starts from the first."
        ),
    ] = False,
    csv: Annotated[Path | None, typer.Option(help="File for one row every --every seconds.")] = None,
    jsonl: Annotated[
        str | None, typer.Option(help="File for the same rows as JSON lines; - for standard output.")
    ] = None,
    out_file: Annotated[
        Path | None,
        written_at_end("Write vehicle.toml here, with what the filter has learned of the robot.", "--out"),
    ] = None,
    every: Annotated[float, typer.Option(help="Seconds between rows; 0 for every sample.", min=0.0)] = 0.1,
) -> None:
    """Show the pose by odometry, IPEC and the filter, with what was corrected and why."""
    from omnimate.cli.robots import nominal_vehicle
    from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL
    from omnimate.ipec.tracker import OneTruckTracker, Tracker

    if (recording is None) == (bus is None):
        raise CallError(
            "track follows either a robot (--bus URL) or a recording (its folder); give one of them"
        )
    if fixes and recording is None:
        raise CallError("--fixes takes the poses of a recording; a bus has none")
    prior = NOMINAL if uncalibrated else CALIBRATED
    with open_rows(csv, jsonl) as writer:
        if recording is not None:
            learned = _track_recording(recording, prior, writer, every, fixed=fixes)
        else:
            assert bus is not None  # exactly one of them was given
            robot = nominal_vehicle(vehicle)
            tracker = (Tracker if robot.linkage else OneTruckTracker)(robot, prior=prior)
            learned = _track_bus(bus, tracker, writer, seconds=seconds, every=every, listen_only=listen_only)
    if out_file is not None:
        _write(learned, out_file)


def _write(learned: Learned | None, path: Path) -> None:
    """Write the robot with what was learned of it."""
    from omnimate.calib.linkage.learned import learned_vehicle
    from omnimate.vehicle.file import save_vehicle

    if learned is None:
        raise CallError("--out needs two trucks; of one, `omnimate calibrate` learns from absolute poses")
    save_vehicle(learned_vehicle(*learned), path)
    err.print(f"written: {path}; drive again, and compare: nothing should be left to learn")


def _track_recording(
    folder: Path, prior: Prior, writer: RowWriter, every: float, *, fixed: bool
) -> Learned | None:
    from omnimate.calib.recordings import check_frozen
    from omnimate.cli.loading import load
    from omnimate.ipec.tracker import fixes_of, start_by_fixes, track_one_truck, track_recording

    with err.status("reading"):
        recording = load(folder)
        check_frozen(recording)
    fixes, learned = fixes_of(recording) if fixed else None, None
    start = () if fixes is None else start_by_fixes(recording, fixes)  # else the origin
    with err.status("tracking"):
        if recording.vehicle.linkage is None:
            rows = track_one_truck(recording, every, *start, fixes=fixes, prior=prior)
        else:
            rows, estimate = track_recording(recording, every, *start, fixes=fixes, prior=prior)
            learned = recording.vehicle, estimate.slow, estimate.findings
        last = None
        for last in rows:
            writer.write(last)
    if learned is not None:
        for disturbance in estimate.disturbances:
            note(disturbance_in_words(disturbance, recording.time[0], recording.vehicle))
    if last is not None:
        show_summary(last, learned, to_stdout=writer.leaves_stdout)
    return learned


def _track_bus(
    bus: str,
    tracker: Tracker | OneTruckTracker,
    writer: RowWriter,
    *,
    seconds: float | None,
    every: float,
    listen_only: bool,
) -> Learned | None:
    from omnimate.cli.driver_reports import report_problems

    reader, _ = open_reader(tracker.vehicle, bus, listen_only=listen_only)
    reader.end_after(seconds)
    with reader, contextlib.suppress(KeyboardInterrupt):
        follow_robot(reader.samples(), tracker, writer, seconds=seconds, every=every)
    report_problems(reader.report())
    learned = tracker.learned
    if tracker.started:
        show_summary(tracker.row(), learned, to_stdout=writer.leaves_stdout)
    return learned
