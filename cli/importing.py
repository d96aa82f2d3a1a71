"""`omnimate import`: recording folders from bus logs, CSV files and ROS bags."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, progress_bar, report_problem, say, warn
from omnimate.cli.descriptions import vehicle_of
from omnimate.cli.errors import CallError
from omnimate.cli.loading import load, report_problems

if TYPE_CHECKING:
    from omnimate.files.importers.rosbag.plan import Plan
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording

app = typer.Typer(
    help="Make recording folders from bus logs, CSV files or ROS bags.",
    no_args_is_help=True,
)

Out = Annotated[Path, typer.Argument(help="Recording folder to write.")]
Vehicle = Annotated[
    Path | None, typer.Option(exists=True, help="vehicle.toml of the robot; else the mapping's own.")
]


@app.command()
def log(
    source: Annotated[
        Path,
        typer.Argument(
            exists=True, help="Log: candump, .asc, .blf, .trc, .pcap, .pcapng, .mf4, python-can's .csv."
        ),
    ],
    to: Out,
    vehicle: Annotated[Path, typer.Option(exists=True, help="vehicle.toml of the robot whose bus it is.")],
) -> None:
    """Take the frames of a bus log of any format, and a vehicle.toml."""
    from omnimate.files.importers.bus_log import import_log
    from omnimate.files.logs.blocks import LogStream
    from omnimate.vehicle.file import load_vehicle

    stream = LogStream(source)
    with _removed_on_failure(to):
        with progress_bar("reading") as watch:
            fd_frames = import_log(stream, load_vehicle(vehicle), to, watch)
        report_problems(stream)
        if fd_frames:
            report_problem(f"{source}: {fd_frames} CAN FD frames left out; recordings hold classical CAN")
        _report_recording(load(to), to)


@app.command()
def csv(
    source: Annotated[Path, typer.Argument(exists=True, help="CSV file of times, counts and poses.")],
    to: Out,
    mapping: Annotated[
        Path,
        typer.Option(exists=True, help="TOML file that says which column is what: docs/how-to/csv-file.md."),
    ],
    vehicle: Vehicle = None,
) -> None:
    """Take a CSV file by a mapping of its columns."""
    from omnimate.files.importers.csv_file.importer import read_csv
    from omnimate.files.recordings.folder import check_free, save_recording

    check_free(to)
    with err.status("reading"):
        recording = read_csv(source, mapping, vehicle_of(vehicle))
        save_recording(recording, to)
    _report_recording(recording, to)


@app.command()
def rosbag(
    source: Annotated[Path, typer.Argument(exists=True, help="A ROS 1 bag, a ROS 2 bag, or an MCAP file.")],
    to: Annotated[Path | None, typer.Argument(help="Recording folder to write.")] = None,
    mapping: Annotated[
        Path | None, typer.Option(exists=True, help="TOML file: topics of channels and poses.")
    ] = None,
    channel: Annotated[
        list[str] | None, typer.Option(help="CHANNEL=TOPIC[:JOINT or FIELD[:UNIT]], once for each channel.")
    ] = None,
    pose: Annotated[list[str] | None, typer.Option(help="TRUCK=TOPIC[:FRAME].")] = None,
    vehicle: Vehicle = None,
    show: Annotated[
        bool, typer.Option("--list", help="Only show the topics, and a mapping by guess.")
    ] = False,
) -> None:
    """Take wheel positions or ticks, joints and poses from a ROS 1 or ROS 2 bag or an MCAP file."""
    from omnimate.files.importers.rosbag.importer import read_bag
    from omnimate.files.recordings.folder import check_free, save_recording

    if show:
        _show_topics(source, vehicle_of(vehicle))
        return
    if to is None:
        raise CallError("import rosbag needs the recording folder to write; --list shows what is in the bag")
    check_free(to)
    plan, robot = _plan(source, mapping, channel or [], pose or [], vehicle_of(vehicle))
    with progress_bar("reading") as progress:
        imported = read_bag(source, plan, robot, progress)
    for note in imported.notes:
        warn(note)
    save_recording(imported.recording, to)
    _report_recording(imported.recording, to)


@contextlib.contextmanager
def _removed_on_failure(folder: Path) -> Iterator[None]:
    """Remove a folder, or the files in it, that were not there before, where the import fails."""
    is_new, before = not folder.exists(), set(folder.glob("*"))
    try:
        yield
    except BaseException:
        for path in set(folder.glob("*")) - before:
            path.unlink()
        if is_new and folder.exists():
            folder.rmdir()
        raise


def _plan(
    source: Path,
    mapping: Path | None,
    channels: list[str],
    poses: list[str],
    vehicle: VehicleParameters | None,
) -> tuple[Plan, VehicleParameters]:
    """Return what of a bag is what, by a mapping, by options, or by guess, and the robot."""
    from omnimate.files.importers.rosbag.guess import ambiguities, guess_plan, plan_as_toml
    from omnimate.files.importers.rosbag.plan import Plan, plan_of_options, read_plan
    from omnimate.files.importers.rosbag.reader import topics_of

    if mapping is not None and (channels or poses):
        raise CallError("--mapping says what --channel and --pose say; give one of the two")
    if mapping is not None:
        return read_plan(mapping, vehicle)
    if vehicle is None:
        raise CallError("import rosbag needs --vehicle, or a --mapping that names the robot")
    stated = plan_of_options(channels, poses)
    if set(vehicle.channels) <= set(stated.channels):
        return stated, vehicle
    topics = topics_of(source)
    guess = guess_plan(topics, vehicle.channels)
    plan = Plan({**guess.channels, **stated.channels}, stated.poses or guess.poses)
    warn("no mapping given; by the names in the bag:\n" + plan_as_toml(plan))
    for sentence in ambiguities(topics, vehicle.channels, plan):
        warn(sentence)
    return plan, vehicle


def _show_topics(source: Path, vehicle: VehicleParameters | None) -> None:
    """Say what is in a bag, and what the names in it suggest."""
    from omnimate.files.importers.rosbag.guess import guess_plan, plan_as_toml
    from omnimate.files.importers.rosbag.reader import topics_of

    topics = topics_of(source)
    for topic in topics:
        parts = f" ({', '.join(topic.parts)})" if topic.parts else ""
        say(f"{topic.count:8d}  {topic.kind:32s}  {topic.name}{parts}")
    plan = guess_plan(topics) if vehicle is None else guess_plan(topics, vehicle.channels)
    say("\n# a mapping by guess:\n" + (plan_as_toml(plan) or "# nothing is named like a wheel"))


def _report_recording(recording: Recording, to: Path) -> None:
    """Say what a recording holds, and how far its odometry is off."""
    from omnimate.files.importers.sanity import odometry_error

    span, period = recording.time[-1] - recording.time[0], recording.vehicle.bus.sync_period
    poses = 0 if recording.poses is None else len(recording.poses.time)
    say(
        f"{len(recording)} samples of {span:.1f} s, one in {1e3 * period:.1f} ms, "
        f"{len(recording.gaps)} gap(s), {poses} poses in {to}"
    )
    for truck in recording.vehicle.trucks:
        seen = odometry_error(recording, truck)
        if seen is not None:
            say(
                f"truck {truck}: nominal odometry ends {1e3 * seen.position:.1f} mm and "
                f"{math.degrees(seen.heading):.2f} deg from the last pose, after {seen.distance:.2f} m"
            )
