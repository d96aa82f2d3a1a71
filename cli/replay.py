"""`omnimate replay`: a recording or a log, as trajectory, or once more onto a bus."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.box import SIMPLE_HEAD
from rich.progress import track
from rich.table import Table

from cli.console import err, out
from cli.loading import tell_problems
from cli.robots import nominal_vehicle

if TYPE_CHECKING:
    from vehicle.assemble import Assembly
    from vehicle.frames import Frames
    from vehicle.logs import LogReadResult
    from vehicle.parameters import TruckName, VehicleParameters
    from vehicle.recording import Recording
    from vehicle.se2 import Array

MOST_PROBLEMS = 20  # shown


def replay(
    source: Annotated[Path, typer.Argument(help="Recording folder, or a log of any format.", exists=True)],
    vehicle: Annotated[
        Path | None, typer.Option(help="vehicle.toml to calculate with; a recording folder has its own.")
    ] = None,
    bus: Annotated[str | None, typer.Option(help="Send the frames onto this bus instead.")] = None,
    pace: Annotated[float, typer.Option(help="Times the recorded pace; 0: at once.", min=0.0)] = 1.0,
    csv: Annotated[Path | None, typer.Option(help="Write the trajectories of all trucks here.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the floor plan: .png, .svg or .pdf.")] = None,
) -> None:
    """Say what a recording or a log holds and where its odometry leads; or send it onto a bus again."""
    from vehicle.logs import read_log

    if bus is not None:
        _send(read_log(_log_of(source)).frames, bus, pace)
        return
    recording = _read(source, vehicle)
    paths = _paths(recording)
    _show_paths(recording, paths)
    if csv is not None:
        _write_csv(recording, paths, csv)
        out.print(f"trajectories: {csv}", soft_wrap=True)
    if plot is not None:
        _draw(recording, paths, plot)
        out.print(f"figure: {plot}", soft_wrap=True)


def _log_of(source: Path) -> Path:
    from vehicle.folder import log_path

    return log_path(source) if source.is_dir() else source


def _read(source: Path, vehicle: Path | None) -> Recording:
    """Return the recording of a folder or a log, with what its frames are on the screen.

    Raises:
        RecordingError: no sample of the vehicle is in it.
    """
    from vehicle.assemble import assemble
    from vehicle.file import load_vehicle
    from vehicle.folder import read_recording
    from vehicle.logs import read_log

    if source.is_dir():
        loaded = read_recording(source)
        log, assembly, poses, run = loaded.log, loaded.assembly, loaded.recording.poses, loaded.recording.run
        robot = loaded.recording.vehicle if vehicle is None else load_vehicle(vehicle)
        _show_log(log, robot)
        if vehicle is not None:
            assembly = assemble(log.frames, robot, str(source))
    else:
        robot, log, poses, run = nominal_vehicle(vehicle), read_log(source), None, None
        _show_log(log, robot)
        assembly = assemble(log.frames, robot, str(source))
    _show_pdos(assembly)
    return replace(assembly.recording, poses=poses, run=run)


def _show_log(log: LogReadResult, vehicle: VehicleParameters) -> None:
    """Print how many frames of each class a log holds, and what could not be read."""
    from vehicle.traffic import CLASSES, classify

    counts = np.bincount(classify(log.frames, vehicle), minlength=len(CLASSES))
    words = [f"{name} {count}" for name, count in zip(CLASSES, counts.tolist(), strict=True) if count]
    out.print(f"{len(log.frames)} frames: {', '.join(words)}", soft_wrap=True)
    tell_problems(log)


def _show_pdos(assembly: Assembly) -> None:
    """Print what became of the PDOs of each node, and the gaps."""
    recording = assembly.recording
    table = Table("PDO", "node", box=SIMPLE_HEAD)
    for head in ("in samples", "missing", "late", "double", "wrong length", "restarts"):
        table.add_column(head, justify="right")
    for one in assembly.pdos:
        numbers = (one.used, one.missing, one.late, one.duplicate, one.wrong_length, one.restarts)
        table.add_row(f"{one.cob_id:03X}h", str(one.node), *map(str, numbers))
    out.print(table)
    start = float(recording.time[0])
    for gap in recording.gaps[:MOST_PROBLEMS]:
        out.print(f"  gap: {gap.channel} {gap.start - start:.3f} to {gap.end - start:.3f} s ({gap.reason})")
    if len(recording.gaps) > MOST_PROBLEMS:
        out.print(f"  and {len(recording.gaps) - MOST_PROBLEMS} more gaps")
    for cob_id, count in sorted(assembly.unknown_pdos.items()):
        out.print(f"  not of this vehicle: PDO {cob_id:03X}h, {count} frames")


def _paths(recording: Recording) -> dict[TruckName, Array]:
    """Return the odometry of every truck `(N, 3)`, each from its first fix where there is one."""
    from vehicle.odometry import dead_reckon

    paths = {}
    for truck in recording.vehicle.trucks:
        start = np.zeros(3)
        if recording.poses is not None:
            fixes = recording.poses.of(truck).pose
            known = fixes[np.isfinite(fixes).all(axis=1)]
            start = known[0] if len(known) else start
        paths[truck] = dead_reckon(recording, truck, start)
    return paths


def _show_paths(recording: Recording, paths: dict[TruckName, Array]) -> None:
    """Print how far each truck went and where odometry ends, and the last fix beside it."""
    from vehicle.se2 import wrap

    duration = float(recording.time[-1] - recording.time[0])
    out.print(f"{len(recording)} samples, {duration:.1f} s, robot {recording.vehicle.name}")
    table = Table("truck", "", box=SIMPLE_HEAD)
    for head in ("path [m]", "x [m]", "y [m]", "heading [degrees]"):
        table.add_column(head, justify="right")
    for truck, path in paths.items():
        length = float(np.hypot(*np.diff(path[:, :2], axis=0).T).sum())
        table.add_row(truck, "odometry at the end", f"{length:.3f}", *_words(path[-1]))
        known = recording.poses.of(truck) if recording.poses is not None else None
        if known is None:
            continue
        rows = np.flatnonzero(np.isfinite(known.pose).all(axis=1))
        if len(rows):
            last = known.pose[rows[-1]]
            row = min(int(np.searchsorted(recording.time, known.time[rows[-1]])), len(path) - 1)
            error = last - path[row]
            table.add_row("", "last absolute fix", "", *_words(last))
            table.add_row("", "fix minus odometry", "", *_words((error[0], error[1], float(wrap(error[2])))))
    out.print(table)


def _words(pose: Sequence[float] | Array) -> tuple[str, str, str]:
    x, y, theta = (float(value) for value in pose)
    return f"{x:.4f}", f"{y:.4f}", f"{math.degrees(theta):.3f}"


def _write_csv(recording: Recording, paths: dict[TruckName, Array], path: Path) -> None:
    """Write time and pose of every truck in the columns of `poses.csv`, without sigmas."""
    from vehicle.atomic import write_text

    lines = ["t,body,x,y,theta"]
    for truck, poses in paths.items():
        lines += [
            f"{time:.6f},{truck},{x:.6f},{y:.6f},{theta:.7f}"
            for time, (x, y, theta) in zip(recording.time.tolist(), poses.tolist(), strict=True)
        ]
    write_text(path, "\n".join([*lines, ""]))


def _draw(recording: Recording, paths: dict[TruckName, Array], path: Path) -> None:
    from figures.plots import Track, plot_floor_plan

    tracks = [Track(f"truck {truck} by odometry", poses) for truck, poses in paths.items()]
    fixes = recording.poses.pose if recording.poses is not None else None
    plot_floor_plan(tracks, path, title=recording.vehicle.name, fixes=fixes)


def _send(frames: Frames, url: str, pace: float) -> None:
    """Send the frames of a log onto a bus, at `pace` times the pace at which they were recorded."""
    import can

    from driver.bus import open_bus
    from vehicle.frames import ERROR, EXTENDED, REMOTE

    with open_bus(url) as bus:
        began, first = time.monotonic(), float(frames.time[0])
        for frame in track(frames, "sending", len(frames), console=err, transient=True):
            if frame.flags & ERROR:
                continue
            ahead = (frame.time - first) / pace - (time.monotonic() - began) if pace else 0.0
            if ahead > 0.0:
                time.sleep(ahead)
            remote = bool(frame.flags & REMOTE)
            message = can.Message(
                arbitration_id=frame.can_id,
                is_extended_id=bool(frame.flags & EXTENDED),
                is_remote_frame=remote,
                data=None if remote else frame.data,
                dlc=frame.length if remote else None,
            )
            bus.send(message, timeout=1.0)
    out.print(f"{len(frames)} frames sent to {url}", soft_wrap=True)
