"""`omnimate record`: a bus -> a recording folder."""

from __future__ import annotations

import contextlib
import math
import shlex
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import say
from omnimate.cli.driver_reports import show_configuration, show_report
from omnimate.cli.errors import CallError
from omnimate.cli.following import follow, open_reader
from omnimate.cli.options import ListenOnly, Protocol, Speed, VehicleFile
from omnimate.cli.robots import nominal_vehicle, program_of

if TYPE_CHECKING:
    from types import FrameType

    from omnimate.driver.robot.driver import Driver
    from omnimate.driver.robot.passive import PassiveReader
    from omnimate.driver.robot.recorder import Recorder
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.sample import Sample


def record(
    folder: Annotated[Path, typer.Argument(help="Recording folder to write.")],
    bus: Annotated[
        str,
        typer.Option(help="socketcan://can0, socketcand://host:port/can0, pcan://PCAN_USBBUS1, or another."),
    ],
    vehicle: VehicleFile = None,
    listen_only: ListenOnly = False,
    seconds: Annotated[
        float | None, typer.Option(help="End after so long [s], also a drive; else at Ctrl-C.", min=0.1)
    ] = None,
    drive: Annotated[
        Protocol | None, typer.Option(help="Enable the drives and drive this. The robot moves.")
    ] = None,
    side: Annotated[float, typer.Option(help="Side of the square [m].", min=0.5, max=100.0)] = 4.0,
    runs: Annotated[int, typer.Option(help="Squares in each direction.", min=1, max=1000)] = 5,
    speed: Speed = 0.2,
    flight_recorder: Annotated[
        Path | None, typer.Option(help="Folder for the last minute before each fault, as a recording.")
    ] = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="Show all that the nodes answered.")] = False,
) -> None:
    """Read the encoders of a robot from its bus and write a recording, until Ctrl-C."""
    from omnimate.cli.driving import drive_program
    from omnimate.driver.errors import BusError, DrivesStopped, NoSync
    from omnimate.driver.robot.passive import PassiveReader
    from omnimate.driver.robot.recorder import Recorder
    from omnimate.vehicle.errors import RecordingError

    robot = nominal_vehicle(vehicle)
    _check_listening(listen_only, drive, flight_recorder)
    program = None if drive is None else program_of(drive, robot, side=side, runs=runs, speed=speed)
    protocol, square = (program.protocol, program.side) if program is not None else (None, None)
    signal.signal(signal.SIGTERM, _interrupt)
    recorder = Recorder(folder, robot, protocol=protocol, side=square)
    try:
        reader, report = open_reader(
            robot, bus, recorder, listen_only=listen_only, flight_recorder=flight_recorder
        )
        if report is not None:
            recorder.use(report.vehicle)
            show_configuration(report, verbose=verbose)
    except BaseException:
        recorder.discard()
        raise
    failure: BusError | DrivesStopped | NoSync | RecordingError | None = None
    try:
        with _closing(recorder, reader), contextlib.suppress(KeyboardInterrupt):
            say(f"{'listening' if listen_only else 'reading'}: {bus}; Ctrl-C ends it")
            if program is not None and not isinstance(reader, PassiveReader):
                drive_program(reader, program, recorder, seconds=seconds)
            else:
                reader.end_after(seconds)
                _follow(reader.samples(), robot, seconds)
    except (BusError, DrivesStopped, NoSync, RecordingError) as error:
        failure = error
    if reader.report().syncs == 0:
        if failure is not None:
            raise CallError(f"{failure}; nothing was recorded") from failure
        recorder.discard()
        raise CallError(f"{bus}: ended before the first SYNC; nothing was recorded")
    show_report(reader.report())
    say(f"recording: {folder}")
    if isinstance(failure, DrivesStopped):
        raise CallError(f"{failure}: {_same_call(folder)}") from failure
    if failure is not None:
        raise failure


def _check_listening(listen_only: bool, drive: Protocol | None, flight_recorder: Path | None) -> None:
    """Check that no more is wanted of a driver that only listens than it can do."""
    if listen_only and flight_recorder is not None:
        raise CallError("--listen-only supervises no node, so it has no --flight-recorder; leave one out")
    if listen_only and drive is not None:
        raise CallError("--listen-only sends nothing, so it cannot --drive; leave one of them out")


def _same_call(folder: Path) -> str:
    """Return the present call as a command, with a folder that does not exist yet."""
    number = 2
    while (other := folder.with_name(f"{folder.name}-{number}")).exists():
        number += 1
    arguments = [str(other) if argument == str(folder) else argument for argument in sys.argv[1:]]
    return shlex.join(["omnimate", *arguments])


@contextlib.contextmanager
def _closing(recorder: Recorder, reader: Driver | PassiveReader) -> Iterator[None]:
    """Close both at the end; discard a recording that fails before its first SYNC."""
    try:
        with recorder, reader:
            yield
    except BaseException:
        if reader.report().syncs == 0:
            recorder.discard()
        raise


def _follow(samples: Iterable[Sample], robot: VehicleParameters, seconds: float | None) -> None:
    """Read samples until the time is up, the source ends or Ctrl-C; the status line has each truck's pose."""
    from omnimate.vehicle.odometry import Odometer

    odometers = {truck: Odometer(robot, truck) for truck in robot.trucks}
    poses: dict[TruckName, PoseTuple] = {}
    followed = follow(samples, seconds, lambda last, passed: _status(last, poses, passed))
    with contextlib.closing(followed):
        for sample in followed:
            poses.update({truck: odometer.step(sample) for truck, odometer in odometers.items()})


def _status(sample: Sample, poses: Mapping[TruckName, PoseTuple], passed: float) -> str:
    words = [f"{passed:8.1f} s  {sample.index + 1} samples"]
    for truck, (x, y, theta) in poses.items():
        words.append(f"{truck}: x {x:.3f} m  y {y:.3f} m  heading {math.degrees(theta):.1f} degrees")
    missing = sample.present.count(False)
    return "   ".join([*words, f"{missing} encoders missing"] if missing else words)


def _interrupt(_signal: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
