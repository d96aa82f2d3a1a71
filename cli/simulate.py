"""`omnimate simulate`: a whole recording without a bus."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import err, say
from omnimate.cli.options import Bumps, Effects, Laps, Protocol, Seed, Side, Speed, TrueVehicle, VehicleFile
from omnimate.cli.robots import nominal_vehicle, program_of, truth_of


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
    from omnimate.files.recordings.folder import save_recording
    from omnimate.vcan_sim.simulate import simulate as run

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
