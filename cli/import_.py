"""`omnimate import`: recording folders from what people have: OptiOdom sets, CSV files, ROS bags."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import Progress

from cli.console import err, out, warn
from vehicle.errors import OmnimateError

app = typer.Typer(
    help="Make recording folders from OptiOdom sets, CSV files or ROS bags.", no_args_is_help=True
)

Out = Annotated[Path, typer.Argument(help="Recording folder to write; with optiodom, a folder of them.")]
Vehicle = Annotated[Path | None, typer.Option(help="vehicle.toml of the robot; else the mapping's own.")]


class CallError(OmnimateError):
    """A call from which something is missing."""


@app.command()
def optiodom(
    source: Annotated[Path, typer.Argument(help="A set, or a folder of sets, of the differential robot.")],
    to: Out,
) -> None:
    """Take the runs of OptiOdom's differential robot: dense poses, one recording folder each."""
    from imports.optiodom import each_run
    from vehicle.folder import save_recording

    count = 0
    for name, recording in each_run(source):
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        save_recording(recording, to / name)
        count += 1
    out.print(f"{count} recordings in {to}")


@app.command()
def csv(
    source: Annotated[Path, typer.Argument(help="CSV file of times, counts and poses.")],
    to: Out,
    mapping: Annotated[Path, typer.Option(help="TOML file that says which column is what: docs/import.md.")],
    vehicle: Vehicle = None,
) -> None:
    """Take a CSV file by a mapping of its columns."""
    from imports.csv_file import read_csv
    from vehicle.file import load_vehicle
    from vehicle.folder import save_recording

    recording = read_csv(source, mapping, None if vehicle is None else load_vehicle(vehicle))
    save_recording(recording, to)
    out.print(f"{len(recording)} samples in {to}")


@app.command()
def rosbag(
    source: Annotated[Path, typer.Argument(help="A ROS 1 bag, a ROS 2 bag, or an MCAP file.")],
    to: Annotated[Path | None, typer.Argument(help="Recording folder to write.")] = None,
    mapping: Annotated[Path | None, typer.Option(help="TOML file: topics of channels and poses.")] = None,
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
    _rosbags_there()
    if show:
        _list(source)
        return
    if to is None or vehicle is None:
        raise CallError(
            "import rosbag needs a folder to write and --vehicle; --list shows what is in the bag"
        )
    from imports.rosbag import read_bag
    from imports.rosbag_plan import plan_of_options, read_plan
    from vehicle.file import load_vehicle
    from vehicle.folder import save_recording

    plan = plan_of_options(channel or [], pose or []) if mapping is None else read_plan(mapping)[0]
    with Progress(console=err, transient=True) as progress:
        task = progress.add_task("reading", total=None)
        imported = read_bag(
            source,
            plan,
            load_vehicle(vehicle),
            lambda done, of: progress.update(task, completed=done, total=of),
        )
    for note in imported.notes:
        warn(note)
    save_recording(imported.recording, to)
    out.print(f"{len(imported.recording)} samples in {to}")


def _rosbags_there() -> None:
    if find_spec("rosbags") is None:
        raise CallError("reading bags needs the extra: pip install 'omnimate[rosbag]'")


def _list(source: Path) -> None:
    from imports.rosbag_guess import as_toml, guess
    from imports.rosbag_reader import topics_of

    topics = topics_of(source)
    for topic in topics:
        parts = f" ({', '.join(topic.parts)})" if topic.parts else ""
        out.print(f"{topic.count:8d}  {topic.kind:32s}  {topic.name}{parts}")
    out.print("\n# a mapping by guess:\n" + as_toml(guess(topics)))
