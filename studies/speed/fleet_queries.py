"""How fast a robot's history and the daily report are read from a million stored results.

Peer: DuckDB over the files of the robot's recordings, one for each day, which hold the same numbers.

Usage: python -m studies.speed.fleet_queries [--robots 1000] [--days 1000] [--repeats 30]

A result for each robot and day: a million with the defaults. Each robot has its history, each night is there,
the last one with all of its tables. Of the recordings' own files only those of one robot are written, because
neither of the two queries opens or lists the others.
"""

import tempfile
from datetime import date, timedelta
from pathlib import Path

import duckdb
import numpy as np

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.tables import encode_columns
from omnimate.fleet.model.histories import History
from omnimate.fleet.report import BadPlace, Change, DailyReport, FloorSummary
from omnimate.fleet.report_store import read_floor, write_report
from omnimate.fleet.segments import PARAMETERS
from omnimate.service.fleets.results import history_view, report_of, report_view, robots_view
from studies.benchmark import cost, options

FIRST = date(2024, 1, 1)
PLACES = 20
CELLS = 20_000  # of 0.25 m: a hall of 40 x 30 m
HISTORY, REPORT = 0.05, 0.2  # [s] that are wanted


def dates(days: int) -> list[str]:
    return [(FIRST + timedelta(days=day)).isoformat() for day in range(days)]


def write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def make_store(folder: Path, robots: int, days: int) -> list[str]:
    """Write the results, and return the robots' names."""
    chance, every = np.random.default_rng(1), dates(days)
    names = [f"tug-{number:04d}" for number in range(robots)]
    summary = encode_columns("nights", {"recordings": [robots], "roughness": [6e-4]})
    for day in every[:-1]:
        write(folder / f"nights/day={day}/night.parquet", summary)
    sigma = [1e-4] * (days * len(PARAMETERS))
    for name in names:
        columns = {
            "day": np.repeat(every, len(PARAMETERS)).tolist(),
            "name": list(PARAMETERS) * days,
            "unit": ["1"] * (days * len(PARAMETERS)),
            "value": chance.normal(0.0, 1e-4, days * len(PARAMETERS)).tolist(),
            "sigma": sigma,
        }
        write(folder / f"histories/robot={name}/history.parquet", encode_columns("histories", columns))
        (folder / f"recordings/robot={name}").mkdir(parents=True)
    for day in every:
        columns = {
            "recording": ["060000"] * len(PARAMETERS),
            "name": list(PARAMETERS),
            "unit": ["1"] * len(PARAMETERS),
            "value": chance.normal(0.0, 1e-4, len(PARAMETERS)).tolist(),
            "sigma": [1e-4] * len(PARAMETERS),
        }
        path = folder / f"numbers/robot={names[0]}/day={day}/060000-0.parquet"
        write(path, encode_columns("numbers", columns))
    write_report(open_files(str(folder)), make_latest_report(names, every, chance))
    return names


def make_latest_report(names: list[str], every: list[str], chance: np.random.Generator) -> DailyReport:
    changes = [
        Change(name, "tug", log_e, "wheelbase", 0.9, every[-3], every[-4], every[-2], "step", 1e-3, 1e-4, 0.0)
        for name, log_e in zip(names, chance.normal(-2.0, 2.0, len(names)).tolist(), strict=True)
    ]
    places = [
        BadPlace("loss", x, y, 0.5, 0.01 * np.eye(2), np.array([0.03]), np.array([0.003]), 80.0, 60)
        for x, y in chance.uniform(0.0, 30.0, (PLACES, 2)).tolist()
    ]
    driven = np.column_stack([chance.uniform(0.0, 40.0, (CELLS, 2)), chance.integers(1, 90, CELLS)])
    history = History(
        names[-1], "tug", PARAMETERS, tuple(every[-30:]), np.arange(30.0), np.zeros((30, 3)),
        np.broadcast_to(1e-8 * np.eye(3), (30, 3, 3)),
    )  # fmt: skip
    judged = tuple(changes), tuple(changes[:10]), (), tuple(places)
    floors = (FloorSummary("", len(names), 6e-4),)
    return DailyReport(every[-1], len(names), (), *judged, floors, (history,), {"": driven})


def main() -> None:
    """Print the median and the largest time of each query, by the wall and by the processor."""
    given = options(__doc__, robots=1000, days=1000, repeats=30)
    with tempfile.TemporaryDirectory() as place:
        names = make_store(Path(place), given.robots, given.days)
        files, database = open_files(place), duckdb.connect()
        raw = f"{place}/numbers/robot={names[0]}/*/*.parquet"
        kept = f"{place}/histories/robot={names[0]}/history.parquet"
        asked = (
            "select day, name, value, sigma from read_parquet('{}', hive_partitioning = true) order by all"
        )

        def ours() -> None:
            history_view(files, names[0])

        def report() -> None:
            judged = report_of(files, "latest")
            report_view(judged)
            robots_view(files, judged)

        def floor() -> None:
            read_floor(files, dates(given.days)[-1], "")

        queries = {
            "history, as the service answers it": (ours, HISTORY),
            "history, DuckDB over its file": (lambda: database.sql(asked.format(kept)).fetchall(), HISTORY),
            "history, DuckDB over recordings": (lambda: database.sql(asked.format(raw)).fetchall(), None),
            "daily report, with all robots": (report, REPORT),
            "floor": (floor, None),
        }
        print(f"{given.robots * given.days} results: {given.robots} robots, {given.days} days")
        medians = {}
        for name, (query, wanted) in queries.items():
            walls, processors, _ = zip(*(cost(query) for _ in range(given.repeats)), strict=True)
            medians[name] = float(np.median(walls))
            aim = f", wanted {1e3 * wanted:.0f}" if wanted else ""
            print(
                f"{name:36s} median {1e3 * np.median(walls):7.1f} ms, largest {1e3 * max(walls):7.1f}, "
                f"processor {1e3 * np.median(processors):7.1f}{aim}"
            )
        ratio = medians["history, DuckDB over recordings"] / medians["history, as the service answers it"]
        print(f"a robot's own file is read {ratio:.0f} times as fast as its recordings' files")


if __name__ == "__main__":
    main()
