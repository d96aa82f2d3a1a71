"""The morning's list: what the results of all recordings say of robots and floor, as of one night."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from datetime import date, timedelta
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.batch.tables import columns_of
from omnimate.fleet.crossings import CELL, Crossings
from omnimate.fleet.errors import FleetError
from omnimate.fleet.joints import JOINT_NUMBERS, NO_JOINTS, Joints
from omnimate.fleet.kept import keep_night, places_before
from omnimate.fleet.model.changes import changes_of, listed
from omnimate.fleet.model.days import histories_of
from omnimate.fleet.model.floor import Driven, Floor, floor_under
from omnimate.fleet.model.histories import ordinary
from omnimate.fleet.morning import Asked, FloorSummary, Night
from omnimate.fleet.segments import Segments

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.model.histories import History
    from omnimate.fleet.morning import BadPlace, Change
    from omnimate.vehicle.se2 import Array

FLOOR_DAYS = 7  # days whose recordings show the floor: a place that is mended is gone after a week
HISTORY_DAYS = 30  # days of a robot's history
AGAIN = 3  # recordings in a row for which triage asks for the same thing, until the robot is named
_FEWEST = 2  # ways from which on a recording says something


def judge_night(
    files: Files,
    day: str | None = None,
    progress: Callable[[int, int], object] = lambda _done, _total: None,
) -> Night:
    """Judge all robots and the floor from the results, and write what came out beside them.

    Args:
        files: The results.
        day: Date of the night, YYYY-MM-DD; that of the last recordings by default.
        progress: Called with how many recordings are read, and of how many.

    Raises:
        FleetError: There are no results, or none of them has poses.
    """
    paths = files.glob("recordings/robot=*/day=*/*.parquet")
    days = sorted({_part(path, "day") for path in paths})
    if not days:
        raise FleetError("results", "no results; run `omnimate fleet run STORE` first")
    night = day or days[-1]
    if night not in days:
        raise FleetError("results", f"no results of {night}; there are some of {days[0]} to {days[-1]}")
    first = (date.fromisoformat(night) - timedelta(days=HISTORY_DAYS - 1)).isoformat()
    chosen = [path for path in paths if first <= _part(path, "day") <= night]
    rows, results = [], []
    for number, path in enumerate(chosen, start=1):
        rows.append((path, columns_of(files.read(path))))
        result = _result(files, path, rows[-1][1])
        if result is not None:
            results.append(result)
        progress(number, len(chosen))
    if not results:
        raise FleetError("results", "no recording with two absolute poses or more; docks suffice")
    judged = _judge(results, night, places_before(files, night))
    today = [(path, row) for path, row in rows if _part(path, "day") == night]
    errors = [
        (_part(path, "robot"), row["recording"][0], row["error"][0]) for path, row in today if row["error"][0]
    ]
    sick = listed(judged.changes)
    asked = _asked(rows, {change.robot for change in sick})
    done = Night(
        night,
        len(today),
        tuple(errors),
        tuple(judged.changes),
        tuple(sick),
        tuple(asked),
        tuple(place for floor in judged.floors.values() for place in floor.places),
        tuple(
            FloorSummary(name, len(judged.recent[name]), floor.roughness)
            for name, floor in judged.floors.items()
        ),
        tuple(judged.histories),
        judged.driven,
    )
    keep_night(files, done)
    return done


@dataclass(frozen=True, slots=True)
class _Judged:
    histories: Sequence[History]
    changes: Sequence[Change]
    floors: dict[str, Floor]
    recent: dict[str, list[Driven]]
    driven: dict[str, Array]


def _judge(results: Sequence[Driven], night: str, known: Sequence[BadPlace]) -> _Judged:
    """Find each floor's places from the last week's recordings, then judge robots from all."""
    week = (date.fromisoformat(night) - timedelta(days=FLOOR_DAYS - 1)).isoformat()
    by_floor: dict[str, list[Driven]] = {}
    for result in results:
        by_floor.setdefault(result.floor, []).append(result)
    recent = {name: [each for each in all_ if each.day >= week] for name, all_ in by_floor.items()}
    floors = {}
    for name in sorted(by_floor, key=lambda name: (-len(recent[name]), name)):
        before = [place for place in known if place.floor == name]
        floor = floor_under(recent[name] or by_floor[name], before)
        floors[name] = Floor(tuple(replace(place, floor=name) for place in floor.places), floor.roughness)
    histories = histories_of([day for name, floor in floors.items() for day in floor.days(by_floor[name])])
    usual = {
        kind: ordinary([history for history in histories if history.kind == kind])
        for kind in {history.kind for history in histories}
    }
    driven = {name: _driven_over(some) for name, some in recent.items() if some}
    return _Judged(histories, changes_of(histories, usual), floors, recent, driven)


def _driven_over(recent: Sequence[Driven]) -> Array:
    """Return the cells that recordings go over: x and y [m] and how many ways, `(N, 3)`."""
    cells = np.concatenate([result.crossings.cell for result in recent])
    unique, counts = np.unique(cells, axis=0, return_counts=True)
    return np.column_stack([CELL * unique, counts])


def _part(path: str, name: str) -> str:
    """Return the value of a partition in a path."""
    return path.partition(f"{name}=")[2].partition("/")[0]


def _result(files: Files, path: str, row: Mapping[str, Any]) -> Driven | None:
    """Return the results of a recording; None where it has too few ways."""
    ways = columns_of(files.read(path.replace("recordings/", "ways/", 1)))
    count = len(ways["way"])
    if count < _FEWEST:
        return None
    segments = Segments(
        ways["time"],
        np.array(ways["residual"]),
        np.array(ways["jacobian"]).reshape(count, 3, 3),
        np.array(ways["rough"]).reshape(count, 3, 3),
        np.array(ways["lever"]),
        np.array(ways["sigma"]).reshape(count, 2, 3),
        np.asarray(ways["follows"], np.bool_),
    )
    over = columns_of(files.read(path.replace("recordings/", "crossings/", 1)))
    crossings = Crossings(
        over["way"],
        np.column_stack([over["x"], over["y"]]),
        np.column_stack([over["loss_x"], over["loss_y"], over["loss_theta"]]),
        over["creep"],
    )
    numbers = columns_of(files.read(path.replace("recordings/", "numbers/", 1)))
    places = [numbers["name"].index(name) for name in JOINT_NUMBERS if name in numbers["name"]]
    joints = Joints(numbers["value"][places], numbers["sigma"][places]) if places else NO_JOINTS
    robot, day = _part(path, "robot"), _part(path, "day")
    return Driven(robot, row["kind"][0], day, segments, crossings, joints, row["floor"][0])


def _asked(rows: Sequence[tuple[str, Mapping[str, Any]]], but: set[str]) -> list[Asked]:
    """Return robots whose last recordings all ask for the same thing, and which are not on the list."""
    by_robot: dict[str, list[tuple[str, str | None, str | None]]] = {}
    for path, row in rows:
        wanted = row["triage"][0] == "mismatch"
        effect, component = (row[name][0] if wanted else None for name in ("effect", "component"))
        by_robot.setdefault(_part(path, "robot"), []).append((_part(path, "day"), effect, component))
    asked = []
    for robot, days in sorted(by_robot.items()):
        last = days[-AGAIN:]
        kinds = Counter((effect, component) for _, effect, component in last)
        (effect, component), count = kinds.most_common(1)[0]
        if count == AGAIN and effect is not None and component is not None and robot not in but:
            asked.append(Asked(robot, effect, component, last[0][0]))
    return asked
