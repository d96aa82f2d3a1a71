"""`omnimate simulate`: a whole recording without a bus; `omnimate sim`: a vehicle whose bus others join."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import err, out, say
from omnimate.cli.errors import CallError
from omnimate.cli.options import Bumps, Effects, Laps, Protocol, Seed, Side, Speed, TrueVehicle, VehicleFile
from omnimate.cli.robots import nominal_vehicle, program_of, truth_of

if TYPE_CHECKING:
    from omnimate.motion.journal import Journal
    from omnimate.motion.program import Program


def simulate(
    folder: Annotated[Path, typer.Argument(help="Recording folder to write.")],
    protocol: Annotated[Protocol, typer.Option(help="What to drive.")] = "umbmark",
    vehicle: VehicleFile = None,
    true_vehicle: TrueVehicle = None,
    side: Side = 4.0,
    runs: Laps = 5,
    speed: Speed = 0.2,
    bump: Bumps = None,
    effects: Effects = None,
    seed: Seed = 0,
    start: Annotated[float | None, typer.Option(help="Time of the first sample [s]; now by default.")] = None,
) -> None:
    """Simulate a robot that drives a protocol, and write its recording: arrays, no bus."""
    from omnimate.files.recordings.folder import LATEST_TIME, check_free, save_recording
    from omnimate.vcan_sim.simulate import simulate as run

    check_free(folder)
    if start is not None and not 0.0 <= start <= LATEST_TIME:
        raise CallError(f"--start {start}: expected a time since 1970, 0 to {LATEST_TIME:.0f} s")
    robot = nominal_vehicle(vehicle)
    truth = truth_of(robot, true_vehicle, bump or (), seed, effects)
    program = program_of(protocol, robot, side=side, runs=runs, speed=speed, seed=seed)
    with err.status("simulating"):
        recording = run(robot, truth, program, start_time=time.time() if start is None else start)
    with err.status("writing"):
        save_recording(recording, folder)
    driven = float(recording.time[-1] - recording.time[0])
    laps = len(recording.run.laps) if recording.run is not None else 0
    say(f"{folder}: {len(recording)} samples, {driven:.0f} s, {laps} laps")


def sim(
    listen: Annotated[str, typer.Option(help="host:port for socketcand clients.")] = "127.0.0.1:29536",
    vehicle: VehicleFile = None,
    true_vehicle: TrueVehicle = None,
    drive: Annotated[
        Protocol | None,
        typer.Option(help="Drive this without commands; else its drives are commanded over the bus."),
    ] = None,
    side: Side = 4.0,
    runs: Laps = 5,
    speed: Speed = 0.2,
    bump: Bumps = None,
    effects: Effects = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(help="Fault of a device, such as reboot:node=2,at=30 [s since the start]."),
    ] = None,
    fixes: Annotated[
        Path | None,
        typer.Option(help="Folder for poses.csv and run.toml of what --drive drove."),
    ] = None,
    seed: Seed = 0,
) -> None:
    """Serve the bus of a simulated vehicle to other processes by the socketcand protocol."""
    from omnimate.vcan_sim.faults import parse_fault
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vcan_sim.self_driving import SelfDriving
    from omnimate.vcan_sim.server import serve

    host, port = _address(listen)
    robot = nominal_vehicle(vehicle)
    truth = truth_of(robot, true_vehicle, bump or (), seed, effects)
    plant = Plant(truth, robot, start_time=time.time(), clock=time.time)
    wheels = None
    if drive is not None:
        program: Program = program_of(drive, robot, side=side, runs=runs, speed=speed, seed=seed)
        wheels = SelfDriving(robot, plant, program, time.time, lambda journal: _write(journal, fixes))

    def ready(bound: int) -> None:
        out.print(f"{robot.name}: listening on {host}:{bound}; read it with")
        out.print(f"  omnimate record OUT --bus socketcand://{host}:{bound}/can0")

    serve(robot, plant, host, port, [parse_fault(text) for text in fault or ()], ready, wheel_speeds=wheels)


def _address(text: str) -> tuple[str, int]:
    host, colon, port = text.rpartition(":")
    if not (host and colon and port.isascii() and port.isdigit() and int(port) < 65536):
        raise CallError(f"{text!r} is not an address; expected host:port, such as 127.0.0.1:29536")
    return host.removeprefix("[").removesuffix("]"), int(port)


def _write(journal: Journal, folder: Path | None) -> None:
    from omnimate.files.recordings.folder import POSES, RUN
    from omnimate.files.recordings.poses_csv import write_poses
    from omnimate.files.recordings.run_toml import write_run

    if folder is None:
        return
    if journal.poses is not None:
        write_poses(journal.poses, folder / POSES)
    write_run(journal.run, folder / RUN)
