"""`omnimate monitor`: the bus or log to watch, and its description."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, out, say
from omnimate.cli.descriptions import descriptions, vehicle_of
from omnimate.cli.errors import CallError
from omnimate.cli.loading import log_of, report_problems
from omnimate.cli.options import DbcFiles, EdsFiles, existing_log

if TYPE_CHECKING:
    from omnimate.cli.descriptions import Descriptions
    from omnimate.cli.monitor.app import MonitorApp
    from omnimate.cli.monitor.lines import Wanted
    from omnimate.driver.robot.bus_watch import BusWatch, Opener, Snapshot
    from omnimate.files.logs.blocks import LogStream
    from omnimate.vehicle.parameters import VehicleParameters

SCREEN = (80, 24)  # characters of a picture
AT_ONCE = 1e9  # times faster than recorded: a year in 32 ms
_POLL_PERIOD = 0.1  # [s] between two checks for the end of a log, without a screen


def monitor(
    source: Annotated[
        Path | None,
        typer.Argument(
            parser=existing_log,
            help="Log of any format or recording folder, replayed as it was; into a pipe, read at once.",
        ),
    ] = None,
    bus: Annotated[str | None, typer.Option(help="Watch this bus, such as socketcan://can0.")] = None,
    vehicle: Annotated[
        Path | None,
        typer.Option(exists=True, help="vehicle.toml: names, values, odometry. A folder has its own."),
    ] = None,
    dbc: DbcFiles = None,
    eds: EdsFiles = None,
    show: Annotated[
        str, typer.Option("--filter", help="Rows to show: 181 180-1FF ~080 node:5 kind:pdo, or words.")
    ] = "",
    record: Annotated[
        Path | None, typer.Option(help="Folder (with a vehicle) or log that the key r records into.")
    ] = None,
    pace: Annotated[
        float | None,
        typer.Option(
            help="How many times faster than recorded to replay a log; 1, or at once into a pipe.", min=0.001
        ),
    ] = None,
    bitrate: Annotated[
        int | None, typer.Option(help="Of the bus [bit/s]; else by the URL or the vehicle.", min=10_000)
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="End after so long [s].", min=0.1)] = None,
    screenshot: Annotated[
        Path | None, typer.Option(help="Draw 80 x 24 characters into this SVG file after --seconds instead.")
    ] = None,
    no_color: Annotated[
        bool, typer.Option("--no-color", help="Without colours; changed bytes have a star.")
    ] = False,
) -> None:
    """Watch a bus in the terminal: rates, values, node states, odometry. Sends nothing."""
    from omnimate.cli.monitor.lines import Wanted
    from omnimate.driver.robot.bus_watch import BusWatch

    if (source is None) == (bus is None):
        raise CallError("monitor watches either a bus (--bus URL) or a log; give one of them")
    if screenshot is not None and seconds is None:
        raise CallError("--screenshot needs --seconds, after which the picture is drawn")
    if screenshot is not None and screenshot.suffix.lower() != ".svg":
        raise CallError(f"--screenshot {screenshot}: expected a name with .svg")
    no_color = no_color or (screenshot is None and bool(os.environ.get("NO_COLOR")))
    robot = vehicle_of(vehicle, source)
    known = descriptions(robot, dbc or (), eds or ())
    rate = bitrate or _bitrate(bus, robot)
    has_screen = out.is_terminal or screenshot is not None
    if pace is None:  # without a screen or an end, the log is read at once
        pace = 1.0 if has_screen or seconds is not None else AT_ONCE
    logs: list[LogStream] = []
    opened = _opener(source, bus, pace, rate, logs)
    name = str(bus or source)
    with BusWatch(opened, robot) as watch:
        if has_screen:
            _screen(no_color=no_color)(
                watch,
                known,
                name=name,
                bitrate=rate,
                wanted=Wanted.of(show),
                target=record,
                seconds=seconds,
                picture=screenshot,
                marks=no_color,
            ).run(headless=screenshot is not None, size=None if screenshot is None else SCREEN)
        elif seconds is None and source is None:
            raise CallError("this is no terminal; give --seconds, after which what was seen is printed")
        else:
            with err.status("watching"):
                _wait(watch, seconds)
            _print(watch.snapshot, known, name, rate, Wanted.of(show))
    if screenshot is not None:
        say(f"written: {screenshot}")
    for log in logs[-1:]:
        report_problems(log)
    if out.is_terminal:
        last = watch.snapshot
        err.print(f"{last.frames} frames in {last.since:.0f} s")


def _opener(
    source: Path | None, bus: str | None, pace: float, bitrate: int | None, logs: list[LogStream]
) -> Opener:
    """Return what opens the bus, or the log as a bus; then the log is appended to `logs`."""
    if bus is not None:
        from omnimate.driver.bus.bus import open_bus

        return lambda: open_bus(bus, bitrate)
    from omnimate.driver.bus.replay import LogBus
    from omnimate.files.logs.blocks import LogStream

    assert source is not None  # one of the two is given
    log = log_of(source)
    next(iter(LogStream(log)))  # refuse a file that is no log before the screen opens

    def open_log() -> LogBus:
        logs.append(LogStream(log))
        return LogBus(logs[-1], pace)

    return open_log


def _bitrate(bus: str | None, robot: VehicleParameters | None) -> int | None:
    from omnimate.driver.bus.adapters import BusUrl

    stated = None if bus is None else BusUrl.of(bus).bitrate
    return robot.bus.bitrate if stated is None and robot is not None else stated


def _screen(*, no_color: bool) -> type[MonitorApp]:
    """Return the screen, after setting whether it has colours."""
    os.environ.pop("NO_COLOR", None)
    if no_color:
        os.environ["NO_COLOR"] = "1"  # by which textual knows
    try:
        from omnimate.cli.monitor.app import MonitorApp
    except ImportError as error:
        raise CallError("the screen needs the library textual: pip install 'omnimate[monitor]'") from error
    return MonitorApp


def _wait(watch: BusWatch, seconds: float | None) -> None:
    """Wait until the time is over or the log has ended."""
    end = None if seconds is None else time.monotonic() + seconds
    while (end is None or time.monotonic() < end) and not watch.snapshot.has_ended:
        time.sleep(_POLL_PERIOD)


def _print(snapshot: Snapshot, known: Descriptions, name: str, bitrate: int | None, wanted: Wanted) -> None:
    """Print the snapshot, where there is no terminal."""
    from omnimate.cli.monitor.lines import event_lines, head_line, node_line, robot_lines, table_lines

    decoder = known.decoder(snapshot.seen if known.vehicle is None else {})
    lines = [head_line(snapshot, name, bitrate)]
    lines += table_lines(wanted.rows(snapshot.rows, decoder), decoder, _WIDE, marks=True)
    lines.append(node_line(snapshot, _WIDE))
    lines += [] if snapshot.robot is None else robot_lines(snapshot.robot, _WIDE)
    lines += event_lines(snapshot, len(snapshot.events), _WIDE)
    for line in lines:
        say(line)


_WIDE = 400  # characters: no line is cut
