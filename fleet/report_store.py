"""The store of daily reports: a few small tables of each day, and one of each robot's history.

A report is read without the results of recordings. The history of a robot is one file, which each daily run
updates, so that the time to read it does not grow with the number of recordings.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.fleet.batch.tables import decode_columns, decode_rows, encode_rows
from omnimate.fleet.errors import FleetError
from omnimate.fleet.report import (
    BadPlace,
    Change,
    DailyReport,
    FloorSummary,
    JudgedRobot,
    RepeatedMismatch,
)
from omnimate.fleet.segments import JOINT_NUMBERS

if TYPE_CHECKING:
    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.model.histories import History
    from omnimate.vehicle.se2 import Array

_LATEST = "latest/night.parquet"


@dataclass(frozen=True, slots=True)
class Course:
    """The values of one quantity of a robot, day by day, without the effect of the floor.

    Values and their standard deviations, `(D,)`, are ratios to vehicle.toml, less 1 (unit "1"), or in "rad";
    days are dates, YYYY-MM-DD.
    """

    name: str
    unit: str
    days: tuple[str, ...]
    value: Array
    sigma: Array


def write_report(files: Files, report: DailyReport) -> None:
    """Write the tables of a report, and update the histories of the robots."""
    for history in report.histories:
        _update_history(files, history, report.day)
    faulty = {change.robot for change in report.faulty}
    tables: dict[str, list[dict[str, Any]]] = {
        "robots": [
            asdict(change) | {"listed": change.robot in faulty}
            for change in sorted(report.changes, key=lambda change: change.robot)
        ],
        "places": [_encode_place(place) for place in report.places],
        "asked": [asdict(mismatch) for mismatch in report.repeated],
        "failed": [
            {"robot": robot, "recording": recording, "error": error}
            for robot, recording, error in report.failed
        ],
        "floor": [
            {"floor": floor, "x": x, "y": y, "count": int(count)}
            for floor, cells in report.driven.items()
            for x, y, count in cells.tolist()
        ],
        "floors": [asdict(floor) for floor in report.floors],
        # Written last: if this table exists, the report is complete.
        "nights": [{"recordings": report.recordings, "roughness": report.roughness}],
    }
    for table, rows in tables.items():
        files.write(_path(table, report.day), encode_rows(table, rows))
    _write_latest(files, max(report.day, find_latest_day(files) or ""))


def delete_report(files: Files, day: str) -> None:
    """Delete the report of a day, if there is one; the one before is the latest then, where it was that."""
    paths = files.glob(f"*/day={day}/night.parquet")
    # `nights` first: a report without it is none.
    for path in sorted(paths, key=lambda path: path != _path("nights", day)):
        files.delete(path)
    if find_latest_day(files) == day:
        days = list_days(files)
        if days:
            _write_latest(files, days[0])
        else:
            files.delete(_LATEST)


def delete_history_day(files: Files, robot: str, day: str) -> None:
    """Delete a day of a robot's history, if it is there."""
    path = _history_path(robot)
    before = decode_rows(files.read(path)) if files.exists(path) else []
    rows = [row for row in before if row["day"] != day]
    if rows:
        files.write(path, encode_rows("histories", rows))
    else:
        files.delete(path)


def _write_latest(files: Files, day: str) -> None:
    files.write(_LATEST, encode_rows("latest", [{"day": day}]))


def list_days(files: Files) -> list[str]:
    """Return the dates of the reports, the newest first."""
    paths = files.glob("nights/day=*/night.parquet")
    return sorted((path.split("/")[1].removeprefix("day=") for path in paths), reverse=True)


def find_latest_day(files: Files) -> str | None:
    """Return the date of the latest report, YYYY-MM-DD; None if there is none."""
    if not files.exists(_LATEST):
        return None
    day: str = decode_rows(files.read(_LATEST))[0]["day"]
    return day


def read_report(files: Files, day: str | None = None) -> DailyReport:
    """Return the report of a day, without histories and cells; the latest one by default.

    Raises:
        FleetError: There is no report, or none of that day.
    """
    chosen = day or find_latest_day(files)
    if chosen is None or not files.exists(_path("nights", chosen)):
        days = list_days(files)
        if not days:
            raise FleetError("results", "no daily report yet; run `omnimate fleet report STORE`")
        raise FleetError("results", f"no daily report of {chosen}; there are some of {days[-1]} to {days[0]}")
    robots = _read_rows(files, "robots", chosen)
    faulty = [_decode_change(row) for row in robots if row["listed"]]
    return DailyReport(
        chosen,
        _read_rows(files, "nights", chosen)[0]["recordings"],
        tuple((row["robot"], row["recording"], row["error"]) for row in _read_rows(files, "failed", chosen)),
        tuple(map(_decode_change, robots)),
        tuple(sorted(faulty, key=lambda change: -change.log_e)),
        tuple(RepeatedMismatch(**row) for row in _read_rows(files, "asked", chosen)),
        _read_places(files, chosen),
        tuple(FloorSummary(**row) for row in _read_rows(files, "floors", chosen)),
    )


def read_robot(files: Files, robot: str) -> JudgedRobot | None:
    """Return a robot as judged in the latest report; None if it is not in it."""
    day = find_latest_day(files)
    if day is None:
        return None
    judged, asked = (
        [row for row in _read_rows(files, table, day) if row["robot"] == robot]
        for table in ("robots", "asked")
    )
    if not judged:
        return None
    repeated = RepeatedMismatch(**asked[0]) if asked else None
    return JudgedRobot(_decode_change(judged[0]), repeated, is_faulty=judged[0]["listed"])


def read_floor(files: Files, day: str, floor: str) -> Array:
    """Return the cells of a floor that were driven over: x and y [m] and number of segments, `(N, 3)`."""
    columns = decode_columns(files.read(_path("floor", day)))
    cells = np.column_stack([columns["x"], columns["y"], columns["count"]])
    of_floor: Array = cells[np.array(columns["floor"], str) == floor]
    return of_floor


def read_history(files: Files, robot: str) -> list[Course]:
    """Return the quantities of a robot, day by day; an empty list for a robot that is in no report."""
    path = _history_path(robot)
    if not files.exists(path):
        return []
    columns = decode_columns(files.read(path))
    names, days = np.array(columns["name"]), np.array(columns["day"])
    courses = []
    for name in dict.fromkeys(columns["name"]):
        rows = np.flatnonzero(names == name)
        unit, dates = columns["unit"][int(rows[0])], tuple(days[rows].tolist())
        courses.append(Course(name, unit, dates, columns["value"][rows], columns["sigma"][rows]))
    return courses


def read_places_before(files: Files, day: str) -> tuple[BadPlace, ...]:
    """Return the bad places of the latest report before a day; an empty tuple if there is none."""
    before = [earlier for earlier in list_days(files) if earlier < day]
    return _read_places(files, before[0]) if before else ()


def _update_history(files: Files, history: History, day: str) -> None:
    """Replace the days of a history in its file; earlier and later days are kept."""
    path = _history_path(history.robot)
    rows = [
        {
            "day": date,
            "name": name,
            "unit": "rad" if name in JOINT_NUMBERS else "1",
            "value": float(value),
            "sigma": float(sigma),
        }
        for date, values, sigmas in zip(history.dates, history.value, history.sigma(), strict=True)
        for name, value, sigma in zip(history.names, values, sigmas, strict=True)
    ]
    if files.exists(path):
        before = decode_rows(files.read(path))
        rows += [row for row in before if not history.dates[0] <= row["day"] <= day]
    rows.sort(key=lambda row: (row["day"], row["name"]))
    files.write(path, encode_rows("histories", rows))


def _history_path(robot: str) -> str:
    return f"histories/robot={robot}/history.parquet"


def _path(table: str, day: str) -> str:
    return f"{table}/day={day}/night.parquet"


def _read_rows(files: Files, table: str, day: str) -> list[dict[str, Any]]:
    return decode_rows(files.read(_path(table, day)))


def _decode_change(row: dict[str, Any]) -> Change:
    return Change(**{name: value for name, value in row.items() if name != "listed"})


def _encode_place(place: BadPlace) -> dict[str, Any]:
    (xx, xy), (_, yy) = place.covariance.tolist()
    vectors = {"size": place.size.tolist(), "sigma": place.sigma.tolist()}
    return asdict(place) | {"xx": xx, "xy": xy, "yy": yy, **vectors}


def _read_places(files: Files, day: str) -> tuple[BadPlace, ...]:
    places = []
    for row in _read_rows(files, "places", day):
        xx, xy, yy, size, sigma = (row.pop(name) for name in ("xx", "xy", "yy", "size", "sigma"))
        covariance = np.array([[xx, xy], [xy, yy]])
        places.append(BadPlace(covariance=covariance, size=np.array(size), sigma=np.array(sigma), **row))
    return tuple(places)
