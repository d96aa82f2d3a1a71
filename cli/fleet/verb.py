"""`omnimate fleet`: a simulated hall of robots, a night's work on a store, and the morning's list."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import out, progress_bar

app = typer.Typer(
    help="Recordings of many robots: which robot is sick, which place of the floor is bad.",
    no_args_is_help=True,
)


@app.command("simulate")
def simulate_hall(
    store: Annotated[Path, typer.Argument(help="Folder of the store to write.")],
    robots: Annotated[int, typer.Option(help="Robots, of three types in turn.", min=1)] = 12,
    days: Annotated[int, typer.Option(help="Days.", min=1)] = 6,
    laps: Annotated[int, typer.Option(help="Laps of each robot on each day.", min=1)] = 1,
    minutes: Annotated[float, typer.Option(help="Time of a lap, about [min].", min=0.5, max=60.0)] = 5.0,
    sick: Annotated[int, typer.Option(help="Robots that turn sick, half of them gradually.", min=0)] = 1,
    places: Annotated[
        int, typer.Option(help="Bad places of the floor: joint, oily patch and slope in turn.", min=0)
    ] = 3,
    pose_period: Annotated[
        float, typer.Option(help="Time between readings of the pose [s]; 0 for docks alone.", min=0.0)
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of all that is drawn by chance.", min=0)] = 0,
) -> None:
    """Write the recordings of a simulated hall, and its truth as hall.toml."""
    from omnimate.vcan_sim.hall.hall import draw_hall
    from omnimate.vcan_sim.hall.store import write_store

    hall = draw_hall(robots, days, sick=sick, places=places, seed=seed)
    with progress_bar("driving") as progress:
        count = write_store(
            hall, store, range(days), laps, minutes, pose_period=pose_period, progress=progress
        )
    out.print(f"{store}: {count} recordings of {robots} robots on {days} days", soft_wrap=True)
