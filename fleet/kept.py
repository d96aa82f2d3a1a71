"""A night's tables: written when it was judged, read in the morning without any recording's results.

The morning's list is a few small files of its day. A robot's history is one file, which each night brings up
to date: so it is read at once, however many recordings a store has.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.fleet.batch.tables import columns_of, parquet_bytes
from omnimate.fleet.errors import FleetError
from omnimate.fleet.joints import JOINT_NUMBERS
from omnimate.fleet.morning import Asked, BadPlace, Change, FloorSummary, Judged, Morning

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.model.histories import History
    from omnimate.fleet.morning import Night
    from omnimate.vehicle.se2 import Array

_CHANGE = ("robot", "kind", "log_e", "name", "share", "since", "earliest", "latest", "shape", "size")
_CHANGES = (*_CHANGE, "sigma", "per_day")
_PLACE = ("floor", "effect", "x", "y", "reach", "gain", "crossings")
_FLOOR = ("floor", "recordings", "roughness")
_FAILED = ("robot", "recording", "error")
_LATEST = "latest/night.parquet"
# The last one says that all are there.
_OF_DAY = ("robots", "places", "asked", "failed", "floor", "floors", "nights")


@dataclass(frozen=True, slots=True)
class Course:
    """One number of a robot, day by day, without what the floor did.

    Attributes:
        name: Name of the number.
        unit: "1", relative to vehicle.toml, or "rad".
        days: Dates, YYYY-MM-DD, `(D,)`.
        value: Values in that unit, `(D,)`.
        sigma: Their standard deviations, `(D,)`.
    """

    name: str
    unit: str
    days: tuple[str, ...]
    value: Array
    sigma: Array


def keep_night(files: Files, night: Night) -> None:
    """Write a night's tables, and bring the robots' histories up to date."""
    for history in night.histories:
        _keep_history(files, history, night.day)
    tables = {
        "robots": _robot_rows(night),
        "places": _place_rows(night.places),
        "asked": {name: [getattr(asked, name) for asked in night.asked] for name in _names(Asked)},
        "failed": {name: [row[place] for row in night.errors] for place, name in enumerate(_FAILED)},
        "floor": _floor_columns(night.driven),
        "floors": {name: [getattr(each, name) for each in night.floors] for name in _FLOOR},
        "nights": {
            "recordings": np.array([night.recordings], np.int32),
            "roughness": [night.roughness],
        },
    }
    for table in _OF_DAY:
        files.write(_path(table, night.day), parquet_bytes(table, tables[table]))
    latest = max(night.day, last_night(files) or "")
    files.write(_LATEST, parquet_bytes("latest", {"day": [latest]}))


def days_kept(files: Files) -> list[str]:
    """Return the dates of the nights that were judged, the newest first."""
    paths = files.glob("nights/day=*/night.parquet")
    return sorted((path.split("/")[1].removeprefix("day=") for path in paths), reverse=True)


def last_night(files: Files) -> str | None:
    """Return the date of the last night that was judged; None where there is none."""
    if not files.glob(_LATEST):
        return None
    day: str = columns_of(files.read(_LATEST))["day"][0]
    return day


def read_morning(files: Files, day: str | None = None) -> Morning:
    """Return what a night's tables say; of the last night by default.

    Raises:
        FleetError: No night was judged, or not that one.
    """
    night = day or last_night(files)
    if night is None or not files.glob(_path("nights", night)):
        days = days_kept(files)
        if not days:
            raise FleetError("results", "no night was judged yet; run `omnimate fleet report STORE`")
        raise FleetError("results", f"no night of {night}; there are some of {days[-1]} to {days[0]}")
    robots, asked, failed, summary = (
        _columns(files, table, night) for table in ("robots", "asked", "failed", "nights")
    )
    changes = [Change(**row) for row in _rows(robots, _CHANGES)]
    on_list = [change for change, listed in zip(changes, robots["listed"], strict=True) if listed]
    return Morning(
        night,
        int(summary["recordings"][0]),
        tuple(zip(*(failed[name] for name in _FAILED), strict=True)),
        tuple(changes),
        tuple(sorted(on_list, key=lambda change: -change.log_e)),
        tuple(Asked(**row) for row in _rows(asked, _names(Asked))),
        _places(files, night),
        _floors(files, night),
    )


def read_judged(files: Files, robot: str) -> Judged | None:
    """Return what the last night says of a robot; None where it says nothing."""
    night = last_night(files)
    if night is None:
        return None
    robots, asked = (_of_robot(_columns(files, table, night), robot) for table in ("robots", "asked"))
    change = next(iter(_rows(robots, _CHANGES)), None)
    if change is None:
        return None
    wanted = next((Asked(**row) for row in _rows(asked, _names(Asked))), None)
    return Judged(Change(**change), wanted, is_listed=bool(robots["listed"][0]))


def read_floor(files: Files, day: str, floor: str) -> Array:
    """Return the cells of a floor that were driven over before a night: x, y [m], how often, `(N, 3)`."""
    columns = _columns(files, "floor", day)
    cells = np.column_stack([columns["x"], columns["y"], columns["count"]])
    on: Array = cells[np.array(columns["floor"], str) == floor]
    return on


def read_history(files: Files, robot: str) -> list[Course]:
    """Return a robot's numbers, day by day; none of a robot that was in no night."""
    path = _history_path(robot)
    if not files.glob(path):
        return []
    columns = columns_of(files.read(path))
    names, days = np.array(columns["name"]), np.array(columns["day"])
    courses = []
    for name in dict.fromkeys(columns["name"]):
        rows = np.flatnonzero(names == name)
        unit = columns["unit"][int(rows[0])]
        course = Course(
            name, unit, tuple(days[rows].tolist()), columns["value"][rows], columns["sigma"][rows]
        )
        courses.append(course)
    return courses


def places_before(files: Files, night: str) -> tuple[BadPlace, ...]:
    """Return the places of the last night that was judged before one."""
    before = [day for day in days_kept(files) if day < night]
    return _places(files, before[0]) if before else ()


def _keep_history(files: Files, history: History, night: str) -> None:
    """Replace the days of a history in its file; older days stay, and so do later ones."""
    path = _history_path(history.robot)
    sigma = np.sqrt(np.diagonal(history.covariance, axis1=1, axis2=2))
    rows = [
        (day, name, "rad" if name in JOINT_NUMBERS else "1", float(value), float(spread))
        for day, values, spreads in zip(history.dates, history.value, sigma, strict=True)
        for name, value, spread in zip(history.names, values, spreads, strict=True)
    ]
    names = "day", "name", "unit", "value", "sigma"
    if files.glob(path):
        before = columns_of(files.read(path))
        first = history.dates[0]
        rows += [
            (row["day"], row["name"], row["unit"], row["value"], row["sigma"])
            for row in _rows(before, names)
            if not first <= row["day"] <= night
        ]
    rows.sort()
    columns = dict(zip(names, map(list, zip(*rows, strict=True)), strict=True))
    files.write(path, parquet_bytes("histories", columns))


def _history_path(robot: str) -> str:
    return f"histories/robot={robot}/history.parquet"


def _path(table: str, day: str) -> str:
    return f"{table}/day={day}/night.parquet"


def _columns(files: Files, table: str, day: str) -> dict[str, Any]:
    return columns_of(files.read(_path(table, day)))


def _names(kind: type[Asked]) -> tuple[str, ...]:
    return tuple(kind.__dataclass_fields__)


def _rows(columns: dict[str, Any], names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the rows of columns, with plain Python's numbers."""
    plain = {
        name: columns[name].tolist() if isinstance(columns[name], np.ndarray) else columns[name]
        for name in names
    }
    return [dict(zip(names, row, strict=True)) for row in zip(*plain.values(), strict=True)]


def _of_robot(columns: dict[str, Any], robot: str) -> dict[str, Any]:
    """Return the rows of columns that are of a robot."""
    rows = [row for row, name in enumerate(columns["robot"]) if name == robot]
    return {
        name: [column[row] for row in rows] if isinstance(column, list) else column[rows]
        for name, column in columns.items()
    }


def _floor_columns(driven: Mapping[str, Array]) -> dict[str, Any]:
    cells = np.concatenate([np.zeros((0, 3)), *driven.values()])
    return {
        "floor": [name for name, some in driven.items() for _ in some],
        "x": cells[:, 0],
        "y": cells[:, 1],
        "count": cells[:, 2].astype(np.int32),
    }


def _floors(files: Files, day: str) -> tuple[FloorSummary, ...]:
    return tuple(FloorSummary(**row) for row in _rows(_columns(files, "floors", day), _FLOOR))


def _places(files: Files, day: str) -> tuple[BadPlace, ...]:
    columns = _columns(files, "places", day)
    return tuple(
        BadPlace(
            row["effect"],
            row["x"],
            row["y"],
            row["reach"],
            np.array([[row["xx"], row["xy"]], [row["xy"], row["yy"]]]),
            np.array(row["size"]),
            np.array(row["sigma"]),
            row["gain"],
            row["crossings"],
            row["floor"],
        )
        for row in _rows(columns, (*_PLACE, "xx", "xy", "yy", "size", "sigma"))
    )


def _robot_rows(night: Night) -> dict[str, Any]:
    names = {change.robot for change in night.sick}
    changes = sorted(night.changes, key=lambda change: change.robot)
    columns: dict[str, Any] = {field: [getattr(change, field) for change in changes] for field in _CHANGES}
    return {**columns, "listed": [change.robot in names for change in changes]}


def _place_rows(places: Sequence[BadPlace]) -> dict[str, Any]:
    columns: dict[str, Any] = {field: [getattr(place, field) for place in places] for field in _PLACE}
    return {
        **columns,
        "xx": [float(place.covariance[0, 0]) for place in places],
        "xy": [float(place.covariance[0, 1]) for place in places],
        "yy": [float(place.covariance[1, 1]) for place in places],
        "size": [place.size.tolist() for place in places],
        "sigma": [place.sigma.tolist() for place in places],
    }
