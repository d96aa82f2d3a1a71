"""`omnimate replay`: a recording or a log, as trajectory, or once more onto a bus."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, out, say
from omnimate.cli.descriptions import vehicle_of, warn_of_missing_eds
from omnimate.cli.errors import CallError
from omnimate.cli.loading import log_of, read_drive, report_problems
from omnimate.cli.options import LogSource, written_at_end
from omnimate.cli.robots import nominal_vehicle
from omnimate.cli.tables import new_table, pose_cells, show

if TYPE_CHECKING:
    from omnimate.files.logs.assemble import Assembly
    from omnimate.files.logs.blocks import LogReadResult
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.trajectories import Trajectory

MAX_GAPS_SHOWN = 20


def replay(
    source: LogSource,
    vehicle: Annotated[
        Path | None,
        typer.Option(exists=True, help="vehicle.toml to calculate with; a recording folder has its own."),
    ] = None,
    bus: Annotated[str | None, typer.Option(help="Send the frames onto this bus instead.")] = None,
    pace: Annotated[
        float, typer.Option(help="How many times faster than recorded to send; 0 sends at once.", min=0.0)
    ] = 1.0,
    frames: Annotated[
        float,
        typer.Option(help="Print all frames and commands up to so long from the fault [s].", min=0.0),
    ] = 0.1,
    csv: Annotated[Path | None, written_at_end("Write the trajectories of all trucks here.")] = None,
    plot: Annotated[Path | None, written_at_end("Draw the floor plan: .png, .svg or .pdf.")] = None,
) -> None:
    """Summarise a recording or a log and its odometry, or send its frames onto a bus again.

    Of a recording of the flight recorder, states, decisions and frames are printed first, from the fault.
    """
    if bus is not None:
        _send(source, bus, pace)
        return
    from omnimate.files.recordings.events_jsonl import EVENTS
    from omnimate.vehicle.atomic import write_text
    from omnimate.vehicle.errors import RecordingError
    from omnimate.vehicle.trajectories import format_trajectories, trajectories

    if plot is not None:
        from omnimate.figures.files import check_format

        check_format(plot)
    robot = vehicle_of(vehicle) if source.is_dir() else nominal_vehicle(vehicle)
    if (source / EVENTS).exists():
        _show_timeline(source, robot, frames)
    try:
        loaded = read_drive(source, robot, _show_log)
        recording = loaded.recording
        warn_of_missing_eds(recording.vehicle)
        _show_pdos(loaded.assembly)
        paths = trajectories(recording)
    except RecordingError as error:
        if vehicle is None and not source.is_dir():
            raise CallError(f"{error}; that is the reference robot's: give --vehicle for another") from error
        raise
    _show_paths(recording, paths)
    if csv is not None:
        write_text(csv, format_trajectories(paths))
        say(f"trajectories: {csv}")
    if plot is not None:
        _draw(recording, paths, plot)
        say(f"figure: {plot}")


def _show_timeline(folder: Path, vehicle: VehicleParameters | None, margin: float) -> None:
    """Print NMT states, services and the driver's events in order of time, from the first fault.

    Within `margin` [s] of the fault all frames and commands are printed.
    """
    from omnimate.files.logs.blocks import read_log
    from omnimate.files.logs.bus_events import BusEvents
    from omnimate.files.logs.decoding import FrameDecoder
    from omnimate.files.recordings.events_jsonl import EVENTS, read_events
    from omnimate.files.recordings.folder import VEHICLE
    from omnimate.vehicle.file import load_vehicle

    events = read_events(folder / EVENTS)
    start = next((event.time for event in events if event.kind == "fault"), events[0].time if events else 0.0)
    decoder, states = FrameDecoder(vehicle or load_vehicle(folder / VEHICLE)), BusEvents()
    lines: list[tuple[float, str, str]] = []
    for frame in read_log(log_of(folder)).frames:
        seen = states.take(frame)
        if seen is not None:
            lines.append((frame.time, f"{frame.can_id:03X}h", _of_node(seen.node, seen.what)))
        elif abs(frame.time - start) <= margin:
            lines.append((frame.time, f"{frame.can_id:03X}h", decoder(frame)))
    lines += [
        (event.time, event.kind, _of_node(event.node, event.what))
        for event in events
        if event.kind != "command" or abs(event.time - start) <= margin
    ]
    for time, kind, words in sorted(lines, key=operator.itemgetter(0)):
        say(f"{time - start:+11.6f} s  {kind:<8} {words}")


def _of_node(node: int | None, what: str) -> str:
    return what if node is None else f"node {node}: {what}"


def _send(source: Path, bus: str, pace: float) -> None:
    """Send the frames of a log onto a bus."""
    from rich.progress import track

    from omnimate.driver.bus.replay import send_frames
    from omnimate.files.logs.blocks import LogBlocks

    log = LogBlocks(log_of(source))
    frames = itertools.chain.from_iterable(log)
    send_frames(track(frames, "sending", total=None, console=err, transient=True), bus, pace)
    say(f"{log.frames} frames sent to {bus}")
    report_problems(log)


def _show_log(log: LogReadResult, vehicle: VehicleParameters) -> None:
    """Print how many frames of each class a log holds, and what could not be read."""
    from omnimate.files.logs.frame_classes import count_classes

    words = [f"{name} {count}" for name, count in count_classes(log.frames, vehicle).items() if count]
    say(f"{len(log.frames)} frames: {', '.join(words)}")
    report_problems(log.blocks)


def _show_pdos(assembly: Assembly) -> None:
    """Print how many PDOs of each node are in samples, missing, late or wrong, and the gaps."""
    recording = assembly.recording
    heads = ("in samples", "missing", "late", "double", "wrong length", "restarts")
    rows = [(f"{cob_id:03X}h", *map(str, numbers)) for cob_id, *numbers in map(astuple, assembly.pdos)]
    show(new_table("", ("PDO", "node"), heads, rows))
    start = float(recording.time[0])
    for gap in recording.gaps[:MAX_GAPS_SHOWN]:
        out.print(f"  gap: {gap.channel} {gap.start - start:.3f} to {gap.end - start:.3f} s ({gap.reason})")
    if len(recording.gaps) > MAX_GAPS_SHOWN:
        out.print(f"  and {len(recording.gaps) - MAX_GAPS_SHOWN} more gaps")
    for cob_id, count in sorted(assembly.unknown_pdos.items()):
        out.print(f"  not of this vehicle: PDO {cob_id:03X}h, {count} frames")


def _show_paths(recording: Recording, paths: Sequence[Trajectory]) -> None:
    """Print the travel of each truck, where its odometry ends, and the last absolute pose."""
    duration = float(recording.time[-1] - recording.time[0])
    out.print(f"{len(recording)} samples, {duration:.1f} s, robot {recording.vehicle.name}")
    table = new_table("", ("truck", ""), ("path [m]", "x [m]", "y [m]", "heading [degrees]"))
    for path in paths:
        table.add_row(path.truck, "odometry at the end", f"{path.length:.3f}", *pose_cells(path.pose[-1]))
        if path.fix is not None and path.error is not None:
            table.add_row("", "last absolute fix", "", *pose_cells(path.fix))
            table.add_row("", "fix minus odometry", "", *pose_cells(path.error))
    show(table)


def _draw(recording: Recording, paths: Sequence[Trajectory], file: Path) -> None:
    from omnimate.figures.floor_plan import Track, plot_floor_plan

    tracks = [Track(f"truck {path.truck} by odometry", path.pose) for path in paths]
    fixes = recording.poses.pose if recording.poses is not None else None
    plot_floor_plan(tracks, file, title=recording.vehicle.name, fixes=fixes)
