"""The daily judgement: faulty robots and bad places, from the results of all recordings up to a day."""

from __future__ import annotations

from dataclasses import replace
from datetime import date, timedelta
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.batch.store import is_date
from omnimate.fleet.batch.tables import decode_columns, decode_rows
from omnimate.fleet.errors import FleetError
from omnimate.fleet.features import features_from_tables
from omnimate.fleet.model.changes import detect_changes, select_faulty
from omnimate.fleet.model.floor import Floor, estimate_floor
from omnimate.fleet.model.histories import estimate_nominal_variation, make_histories
from omnimate.fleet.report import DailyReport, FloorSummary, RepeatedMismatch
from omnimate.fleet.report_store import read_places_before, write_report
from omnimate.fleet.segments import CELL

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.features import RecordingFeatures
    from omnimate.fleet.report import BadPlace
    from omnimate.vehicle.se2 import Array

# [days] whose recordings are used for the floor: a repaired place is no longer reported after them.
FLOOR_DAYS = 7
HISTORY_DAYS = 30  # [days] of a robot's history
MIN_REPEATS = 3  # consecutive recordings with the same mismatch by triage, for which the robot is reported


def judge_day(
    files: Files,
    day: str | None = None,
    progress: Callable[[int, int], object] = lambda _done, _total: None,
) -> DailyReport:
    """Judge all robots and the floors from the results, and write the report into these.

    The day, YYYY-MM-DD, is that of the last recordings by default; `progress` is called with (recordings
    read, number of recordings).

    Raises:
        FleetError: There are no results of that day, or no recording has two absolute poses.
    """
    found = files.glob("recordings/robot=*/day=*/*.parquet")
    paths = [path for path in found if is_date(_partition(path)["day"])]
    days = sorted({_partition(path)["day"] for path in paths})
    if not days:
        raise FleetError("results", "no results; run `omnimate fleet run STORE` first")
    last = day or days[-1]
    if last not in days:
        raise FleetError("results", f"no results of {last}; there are some of {days[0]} to {days[-1]}")
    first = _days_before(last, HISTORY_DAYS)
    chosen = [path for path in paths if first <= _partition(path)["day"] <= last]
    rows, features = [], []
    for number, path in enumerate(chosen, start=1):
        row, recording = read_results(files, path)
        rows.append(row)
        if recording is not None:
            features.append(recording)
        progress(number, len(chosen))
    if not features:
        raise FleetError("results", "no recording with two absolute poses or more; docks suffice")
    report = make_report(last, rows, features, read_places_before(files, last))
    undated = tuple(_describe_undated(path) for path in found if not is_date(_partition(path)["day"]))
    report = replace(report, failed=report.failed + undated)
    write_report(files, report)
    return report


def read_results(files: Files, path: str) -> tuple[dict[str, Any], RecordingFeatures | None]:
    """Return the row of one recording with its robot and day, and its features; None without enough segments.

    The path is that of its file in the table `recordings`.

    Raises:
        FleetError: One of its files cannot be read.
    """
    try:
        row = decode_rows(files.read(path))[0] | _partition(path)
        ways, crossed, numbers = (
            decode_columns(files.read(path.replace("recordings/", f"{table}/", 1)))
            for table in ("ways", "crossings", "numbers")
        )
    except (OSError, ValueError) as error:  # pyarrow raises either for what is damaged
        repair = f"delete {path}, and `omnimate fleet run STORE` writes all of them again"
        raise FleetError(
            "results", f"one of a recording's files is damaged or gone: {error}; {repair}"
        ) from error
    return row, features_from_tables(row, ways, crossed, numbers)


def make_report(
    day: str,
    rows: Sequence[Mapping[str, Any]],
    features: Sequence[RecordingFeatures],
    known: Sequence[BadPlace],
) -> DailyReport:
    """Return the report of a day: places from the recordings of a week, robots from all recordings.

    Rows of `recordings` up to that day have `robot` and `day`, and are in order of time for each robot;
    features are of those with enough segments; `known` are the bad places of the previous report.
    """
    week = _days_before(day, FLOOR_DAYS)
    by_floor: dict[str, list[RecordingFeatures]] = {}
    for recording in features:
        by_floor.setdefault(recording.floor, []).append(recording)
    recent = {
        name: [recording for recording in recordings if recording.day >= week]
        for name, recordings in by_floor.items()
    }
    floors: dict[str, Floor] = {}
    for name in sorted(by_floor, key=lambda name: (-len(recent[name]), name)):
        before = [place for place in known if place.floor == name]
        floor = estimate_floor(recent[name] or by_floor[name], before)
        floors[name] = Floor(tuple(replace(place, floor=name) for place in floor.places), floor.roughness)
    histories = make_histories(
        [robot for name, floor in floors.items() for robot in floor.robot_information(by_floor[name])]
    )
    nominal = {
        kind: estimate_nominal_variation([history for history in histories if history.kind == kind])
        for kind in {history.kind for history in histories}
    }
    changes = detect_changes(histories, nominal)
    faulty = select_faulty(changes)
    today = [row for row in rows if row["day"] == day]
    return DailyReport(
        day,
        len(today),
        tuple((row["robot"], row["recording"], row["error"]) for row in today if row["error"]),
        tuple(changes),
        tuple(faulty),
        tuple(find_repeated_mismatches(rows, {change.robot for change in faulty})),
        tuple(place for floor in floors.values() for place in floor.places),
        tuple(FloorSummary(name, len(recent[name]), floor.roughness) for name, floor in floors.items()),
        tuple(histories),
        {name: _count_cells(recordings) for name, recordings in recent.items() if recordings},
    )


def find_repeated_mismatches(rows: Sequence[Mapping[str, Any]], faulty: set[str]) -> list[RepeatedMismatch]:
    """Return robots that are not faulty, and whose last recordings have the same mismatch by triage."""
    by_robot: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        by_robot.setdefault(row["robot"], []).append(row)
    repeated = []
    for robot, recordings in sorted(by_robot.items()):
        last = recordings[-MIN_REPEATS:]
        results = {(row["triage"], row["effect"], row["component"]) for row in last}
        triage, effect, component = results.pop()
        is_named = triage == "mismatch" and effect is not None and component is not None
        if not results and len(last) == MIN_REPEATS and is_named and robot not in faulty:
            repeated.append(RepeatedMismatch(robot, effect, component, last[0]["day"]))
    return repeated


def _count_cells(recordings: Sequence[RecordingFeatures]) -> Array:
    """Return the cells that recordings cross: x and y [m] and the number of segments over each, `(N, 3)`."""
    cells = np.concatenate([recording.crossings.cell for recording in recordings])
    unique, counts = np.unique(cells, axis=0, return_counts=True)
    return np.column_stack([CELL * unique, counts])


def _days_before(day: str, count: int) -> str:
    """Return the first of `count` days of which `day` is the last."""
    return (date.fromisoformat(day) - timedelta(days=count - 1)).isoformat()


def _describe_undated(path: str) -> tuple[str, str, str]:
    """Return robot, recording and problem of results whose day is no date."""
    named = _partition(path)
    recording = path.rpartition("/")[2].rpartition("-")[0]
    return named["robot"], recording, f"its day {named['day']} is no date; expected YYYY-MM-DD"


def _partition(path: str) -> dict[str, str]:
    """Return the robot and the day of a path."""
    return {name: path.partition(f"{name}=")[2].partition("/")[0] for name in ("robot", "day")}
