"""`omnimate fleet`: a simulated hall of robots, the daily run on a store, and the daily report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from omnimate.cli.console import progress_bar, say

app = typer.Typer(
    help="Recordings of many robots: which robot is faulty, which place of the floor is bad.",
    no_args_is_help=True,
)

MAX_UNREADABLE_SHOWN = 5

Results = Annotated[
    str | None, typer.Option("--out", help="Folder or URL of the results; STORE/results by default.")
]


@app.command("simulate")
def simulate_hall(
    store: Annotated[Path, typer.Argument(help="Folder of the store to write.")],
    robots: Annotated[int, typer.Option(help="Robots, of three types in turn.", min=1)] = 12,
    days: Annotated[int, typer.Option(help="Days.", min=1)] = 6,
    laps: Annotated[int, typer.Option(help="Laps of each robot on each day.", min=1)] = 1,
    minutes: Annotated[float, typer.Option(help="Time of a lap, about [min].", min=0.5, max=60.0)] = 5.0,
    faulty: Annotated[
        int,
        typer.Option("--faulty", "--sick", help="Robots that become faulty, half of them gradually.", min=0),
    ] = 1,
    places: Annotated[
        int, typer.Option(help="Bad places of the floor: joint, oily patch and slope in turn.", min=0)
    ] = 3,
    length: Annotated[float, typer.Option(help="Length of the hall [m].", min=8.0)] = 40.0,
    width: Annotated[float, typer.Option(help="Width of the hall [m].", min=8.0)] = 30.0,
    pose_period: Annotated[
        float, typer.Option(help="Time between readings of the pose [s]; 0 for docks alone.", min=0.0)
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.", min=0)] = 0,
) -> None:
    """Write the recordings of a simulated hall, and its truth as hall.toml."""
    from omnimate.fleet.hall.hall import draw_hall, write_store

    hall = draw_hall(robots, days, faulty=faulty, places=places, length=length, width=width, seed=seed)
    with progress_bar("driving") as progress:
        count = write_store(
            hall, store, range(days), laps, minutes, pose_period=pose_period, progress=progress
        )
    say(f"{store}: {count} recordings of {robots} robots on {days} days")


@app.command("run")
def run(
    store: Annotated[str, typer.Argument(help="Folder or URL of the store: robot=NAME/day=DATE/RECORDING/.")],
    results: Results = None,
    day: Annotated[str | None, typer.Option(help="Only recordings of this date, YYYY-MM-DD.")] = None,
    diagnose: Annotated[bool, typer.Option(help="Make the whole diagnosis where triage asks for it.")] = True,
    jobs: Annotated[int, typer.Option(help="Processes on this machine; more than 1 need Dask.", min=1)] = 1,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, such as tcp://10.0.0.1:8786.")
    ] = None,
    memory: Annotated[
        str, typer.Option(help="Memory of each process on this machine, after which it restarts.")
    ] = "1.5GiB",
) -> None:
    """Process the recordings of a store that have no results yet, and write the results as Parquet."""
    from omnimate.cli.console import report_problem
    from omnimate.fleet.batch.run import Workers, run_batch

    with progress_bar("working") as progress:
        outcome = run_batch(
            store,
            results or f"{store}/results",
            day=day,
            diagnosed=diagnose,
            workers=Workers(jobs, scheduler, memory),
            progress=progress,
        )
    unreadable = f"; {len(outcome.unreadable)} could not be read" if outcome.unreadable else ""
    say(f"{outcome.done} recordings processed, {outcome.known} known before{unreadable}")
    for stored, why in (*outcome.failed, *outcome.unreadable[:MAX_UNREADABLE_SHOWN]):
        report_problem(f"{stored.path}: {why}")
    if len(outcome.unreadable) > MAX_UNREADABLE_SHOWN:
        report_problem(f"and {len(outcome.unreadable) - MAX_UNREADABLE_SHOWN} more could not be read")
    for folder in outcome.undated:
        report_problem(f"{folder}: its day is no date, so that it is left out; expected day=YYYY-MM-DD")


@app.command("report")
def report(
    store: Annotated[str, typer.Argument(help="Folder or URL of the store.")],
    results: Results = None,
    day: Annotated[
        str | None,
        typer.Option(help="Date of the report, YYYY-MM-DD; that of the last recordings by default."),
    ] = None,
    plots: Annotated[
        Path | None, typer.Option(help="Folder for the floor's map and the faulty robots' histories.")
    ] = None,
) -> None:
    """Print the daily report: faulty robots, since when and how fast they get worse; bad places."""
    from omnimate.cli.fleet.report import draw_daily_report, show_daily_report
    from omnimate.fleet.batch.files import open_files
    from omnimate.fleet.judge import judge_day

    with progress_bar("reading") as progress:
        daily = judge_day(open_files(results or f"{store}/results"), day, progress)
    show_daily_report(daily)
    if plots is not None:
        draw_daily_report(daily, plots)
        say(f"pictures in {plots}")
