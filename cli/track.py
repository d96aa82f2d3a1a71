"""`omnimate track`: plain odometry, IPEC and the filter side by side, live from a bus or over a recording."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.live import Live
from rich.text import Text

from cli.console import err, warn
from cli.rows import RowWriter, open_rows
from cli.track_words import disturbance_in_words, frozen_in_words, row_in_words, show_summary
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from driver.driver import Driver
    from driver.passive import PassiveReader
    from ipec.filter import Prior
    from ipec.tracker import Tracker
    from vehicle.parameters import VehicleParameters
    from vehicle.sample import Sample

REFRESH = 0.25  # [s] between two looks at the status line
LOOK = 5.0  # [s] between two looks for frozen channels


class SourceError(OmnimateError):
    """A bus and a recording, or neither."""

    def __init__(self) -> None:
        super().__init__(
            "track follows either a robot (--bus URL) or a recording (its folder); give one of them"
        )


def track(
    recording: Annotated[
        Path | None, typer.Argument(help="Recording folder; else the robot on --bus is followed.")
    ] = None,
    bus: Annotated[
        str | None,
        typer.Option(
            help="socketcan://can0, socketcand://host:port/can0, slcan:///dev/ttyACM0@500000 or virtual://name."
        ),
    ] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(help="vehicle.toml of the robot on the bus; else the reference robot."),
    ] = None,
    listen_only: Annotated[
        bool, typer.Option("--listen-only", help="Send nothing: somebody else produces SYNC.")
    ] = False,
    seconds: Annotated[float | None, typer.Option(help="End after so long; else at Ctrl-C.", min=0.1)] = None,
    uncalibrated: Annotated[
        bool,
        typer.Option("--uncalibrated", help="vehicle.toml holds nominal values: let the filter learn more."),
    ] = False,
    csv: Annotated[Path | None, typer.Option(help="File for one row every --every seconds.")] = None,
    jsonl: Annotated[str | None, typer.Option(help="Likewise as JSON lines; - for standard output.")] = None,
    every: Annotated[float, typer.Option(help="Seconds between rows; 0 for every sample.", min=0.0)] = 0.1,
) -> None:
    """Show where the robot is by odometry, IPEC and the filter, with what was corrected and why."""
    from cli.robots import nominal_vehicle
    from ipec.filter import CALIBRATED, NOMINAL
    from ipec.tracker import Tracker

    if (recording is None) == (bus is None):
        raise SourceError
    prior = NOMINAL if uncalibrated else CALIBRATED
    with open_rows(csv, jsonl) as writer:
        if recording is not None:
            _offline(recording, prior, writer, every)
        elif bus is not None:
            tracker = Tracker(nominal_vehicle(vehicle), prior=prior)
            _live(bus, tracker, writer, seconds=seconds, every=every, listen_only=listen_only)


def _offline(folder: Path, prior: Prior, writer: RowWriter, every: float) -> None:
    """Track a recording at once."""
    from calib.channel_guards import check_frozen
    from ipec.tracker import track_recording
    from vehicle.folder import load_recording

    with err.status("reading"):
        recording = load_recording(folder)
        check_frozen(recording)
    with err.status("tracking"):
        rows, found = track_recording(recording, every, prior=prior)
        last = None
        for last in rows:
            writer.write(last)
    for one in found.disturbances:
        err.print(
            disturbance_in_words(one, recording.time[0], recording.vehicle), markup=False, soft_wrap=True
        )
    if last is not None:
        show_summary(last, found.slow, to_stdout=writer.leaves_stdout)


def _live(
    bus: str,
    tracker: Tracker,
    writer: RowWriter,
    *,
    seconds: float | None,
    every: float,
    listen_only: bool,
) -> None:
    """Track the robot on a bus."""
    reader = _open(tracker.vehicle, bus, listen_only=listen_only)
    with reader, contextlib.suppress(KeyboardInterrupt):
        follow(reader.samples(), tracker, writer, seconds=seconds, every=every)
    if tracker.started:
        show_summary(tracker.row(), tracker.slow, to_stdout=writer.leaves_stdout)


def _open(robot: VehicleParameters, bus: str, *, listen_only: bool) -> Driver | PassiveReader:
    """Return a reader that is ready to give samples."""
    from driver.driver import Driver
    from driver.passive import PassiveReader

    if listen_only:
        return PassiveReader(robot, bus)
    driver = Driver(robot, bus)
    try:
        driver.configure()
    except BaseException:
        driver.close()
        raise
    return driver


def follow(
    samples: Iterable[Sample], tracker: Tracker, writer: RowWriter, *, seconds: float | None, every: float
) -> None:
    """Take samples until the time is up, the source ends or Ctrl-C; write rows, say what happens."""
    first: float | None = None
    shown = written = -math.inf
    looked = 0.0
    told: set[str] = set()
    with Live(console=err, transient=True, auto_refresh=False) as live:
        for sample in samples:
            tracker.step(sample)
            if first is None:
                first = looked = sample.time
            if sample.time - written >= every - 1e-9:
                written = sample.time
                writer.write(tracker.row())
            if sample.time - shown >= REFRESH:
                shown = sample.time
                live.update(Text(row_in_words(tracker.look(), first)), refresh=True)
            look = sample.time - looked >= LOOK
            looked = sample.time if look else looked
            _tell(tracker, first, told, look=look)
            if seconds is not None and sample.time - first >= seconds:
                break


def _tell(tracker: Tracker, first: float, told: set[str], *, look: bool) -> None:
    """Print the disturbances that have ended, and each frozen channel once."""
    for one in tracker.take_disturbances():
        err.print(disturbance_in_words(one, first, tracker.vehicle), markup=False, soft_wrap=True)
    for frozen in tracker.frozen() if look else ():
        if frozen.channel not in told:
            told.add(frozen.channel)
            warn(frozen_in_words(frozen, tracker.vehicle))
