"""`omnimate simulate`: a whole recording without a bus."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import err, out
from omnimate.cli.robots import Protocol, nominal_vehicle, program_of, truth_of


def simulate(
    folder: Annotated[Path, typer.Argument(help="Recording folder to write.")],
    protocol: Annotated[Protocol, typer.Option(help="What to drive.")] = Protocol.umbmark,
    vehicle: Annotated[
        Path | None,
        typer.Option(help="vehicle.toml of the robot as described; else the reference robot."),
    ] = None,
    true_vehicle: Annotated[
        Path | None,
        typer.Option(help="vehicle.toml of the robot as it truly is; else with the errors of U Fig. 11."),
    ] = None,
    side: Annotated[
        float, typer.Option(help="Side of the square, or length of the path [m].", min=0.5, max=100.0)
    ] = 4.0,
    runs: Annotated[int, typer.Option(help="Laps in each direction, or free drives.", min=1, max=1000)] = 5,
    speed: Annotated[float, typer.Option(help="Speed of the wheels [m/s].", min=0.02, max=5.0)] = 0.2,
    bump: Annotated[
        list[str] | None,
        typer.Option(help="Bump on the floor, such as wheel=a.right,after=3,height=0.01; may be repeated."),
    ] = None,
    effects: Annotated[
        Path | None, typer.Option(help="Effects file: physics that the nominal robot leaves out.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the floor, the sonar and the counters.", min=0)] = 0,
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
    out.print(f"{folder}: {len(recording)} samples, {driven:.0f} s, {laps} laps", soft_wrap=True)
