"""`omnimate sim`: a simulated vehicle whose bus other processes join."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from omnimate.cli.console import out
from omnimate.cli.options import Bumps, Effects, Laps, Protocol, Seed, Side, Speed, TrueVehicle, VehicleFile
from omnimate.cli.robots import nominal_vehicle, program_of, truth_of
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from omnimate.motion.journal import Journal
    from omnimate.motion.program import Program


class AddressError(OmnimateError):
    """An address that is not host:port.

    Attributes:
        address: The address as it was given.
    """

    def __init__(self, address: str) -> None:
        super().__init__(f"{address!r} is not an address; expected host:port, such as 127.0.0.1:29536")
        self.address = address


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
    from omnimate.vcan_sim.fault_text import parse_fault
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
        raise AddressError(text)
    return host.removeprefix("[").removesuffix("]"), int(port)


def _write(journal: Journal, folder: Path | None) -> None:
    from omnimate.files.recordings.folder import POSES, RUN, write_poses
    from omnimate.files.recordings.run_toml import write_run

    if folder is None:
        return
    if journal.poses is not None:
        write_poses(journal.poses, folder / POSES)
    write_run(journal.run, folder / RUN)
