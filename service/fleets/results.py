"""What a fleet's results say, as clients see it."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING

from omnimate.fleet.batch.tables import columns_of
from omnimate.fleet.crossings import CELL
from omnimate.fleet.errors import FleetError
from omnimate.fleet.kept import (
    days_kept,
    last_night,
    read_floor,
    read_history,
    read_judged,
    read_morning,
)
from omnimate.fleet.words import of_place, of_robot
from omnimate.service.errors import NotFoundError
from omnimate.service.fleets.models import (
    Change,
    Fleet,
    FleetCourse,
    FleetFloor,
    FleetHistory,
    FleetNight,
    FleetRecording,
    FleetRobot,
    FloorAbout,
    Place,
    RecordingFailed,
    RobotAsked,
)

if TYPE_CHECKING:
    from typing import Any

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.morning import BadPlace, Judged, Morning
    from omnimate.service.store.tables import FleetRow

LATEST = "latest"


def fleet_view(row: FleetRow, results: Files) -> Fleet:
    """Return a fleet with what its last night showed."""
    days = days_kept(results)
    morning = latest(results)
    states = Counter(sorted(robot.state for robot in robots_view(results, morning)))
    return Fleet(
        name=row.id,
        created=row.created,
        nights=len(days),
        night=days[0] if days else None,
        states=dict(states),
        places=len(morning.places) if morning else 0,
    )


def latest(results: Files) -> Morning | None:
    """Return the last night; None where none was judged."""
    day = last_night(results)
    return read_morning(results, day) if day else None


def morning_of(results: Files, day: str) -> Morning:
    """Return a night, or the latest.

    Raises:
        NotFoundError: this night was not judged, or none was.
    """
    try:
        return read_morning(results, None if day == LATEST else day)
    except FleetError as error:
        raise NotFoundError("night", day) from error


def night_view(morning: Morning) -> FleetNight:
    """Return the morning's list."""
    listed = {each.change.robot: _robot_view(each) for each in morning.judged() if each.is_listed}
    return FleetNight(
        day=morning.day,
        recordings=morning.recordings,
        judged=len(morning.changes),
        roughness=morning.roughness,
        floors=[FloorAbout.of(floor) for floor in morning.floors],
        sick=[listed[change.robot] for change in morning.sick],
        places=[place_view(place) for place in morning.places],
        asked=[RobotAsked.of(asked) for asked in morning.asked],
        failed=[
            RecordingFailed(robot=robot, recording=recording, problem=why)
            for robot, recording, why in morning.errors
        ],
    )


def place_view(place: BadPlace) -> Place:
    """Return a bad place."""
    return Place(
        floor=place.floor,
        effect=place.effect,
        says=of_place(place),
        x=place.x,
        y=place.y,
        reach=place.reach,
        covariance=place.covariance.tolist(),
        size=place.size.tolist(),
        per_crossing=place.per_crossing,
        crossings=place.crossings,
    )


def floor_view(results: Files, morning: Morning, floor: str | None) -> FleetFloor:
    """Return a floor as of a night; by default that with most recordings.

    Raises:
        NotFoundError: the fleet has no such floor.
    """
    names = [each.floor for each in morning.floors]
    name = names[0] if floor is None else floor
    if name not in names:
        raise NotFoundError("floor", name)
    driven = [(x, y, int(count)) for x, y, count in read_floor(results, morning.day, name).tolist()]
    places = [place_view(place) for place in morning.places if place.floor == name]
    return FleetFloor(day=morning.day, floor=name, cell=CELL, driven=driven, places=places)


def robots_view(results: Files, morning: Morning | None) -> list[FleetRobot]:
    """Return all robots that have results, in the order of their names."""
    judged = {each.change.robot: _robot_view(each) for each in morning.judged()} if morning else {}
    names = {path.rpartition("robot=")[2] for path in results.glob("recordings/robot=*")}
    return [judged.get(name) or _unjudged(name) for name in sorted(names | set(judged))]


def robot_view(results: Files, robot: str) -> FleetRobot:
    """Return a robot as of the last night.

    Raises:
        NotFoundError: no recording of it has results.
    """
    if not results.glob(f"recordings/robot={robot}"):
        raise NotFoundError("robot", robot)
    judged = read_judged(results, robot)
    return _unjudged(robot) if judged is None else _robot_view(judged)


def history_view(results: Files, robot: str) -> FleetHistory:
    """Return a robot's history.

    Raises:
        NotFoundError: no recording of it has results.
    """
    courses = [
        FleetCourse(
            name=course.name,
            unit="rad" if course.unit == "rad" else "1",
            days=list(course.days),
            value=course.value.tolist(),
            sigma=course.sigma.tolist(),
        )
        for course in read_history(results, robot)
    ]
    return FleetHistory(robot=robot_view(results, robot), courses=courses)


def recordings_view(
    results: Files, robot: str, limit: int, after: str | None
) -> tuple[list[FleetRecording], str | None]:
    """Return a page of a robot's recordings, newest first, and the cursor of the next page.

    Args:
        results: The fleet's results.
        robot: Name of the robot.
        limit: The largest number of recordings of the page.
        after: The cursor, DAY_RECORDING; None for the first page.
    """
    paths = {
        f"{path.split('/')[2].removeprefix('day=')}_{path.split('/')[3].rpartition('-')[0]}": path
        for path in results.glob(f"recordings/robot={robot}/day=*/*.parquet")
    }
    cursors = sorted((cursor for cursor in paths if after is None or cursor < after), reverse=True)
    page = cursors[:limit]
    items = [_recording(cursor[:10], columns_of(results.read(paths[cursor]))) for cursor in page]
    return items, page[-1] if len(cursors) > limit else None


def _recording(day: str, columns: dict[str, Any]) -> FleetRecording:
    row = {name: column[0] for name, column in columns.items()}
    whole = json.loads(row["diagnosis"])["says"] if row["diagnosis"] else None
    return FleetRecording(
        day=day, recording=row["recording"], duration=_number(row["duration"]), way=_number(row["way"]),
        triage=row["triage"], says=row["says"], diagnosis=whole, problem=row["error"],
    )  # fmt: skip


def _number(value: float | None) -> float | None:
    """Return a plain number; None where there is none."""
    return None if value is None or value != value else float(value)  # noqa: PLR0124  # not a number


def _unjudged(robot: str) -> FleetRobot:
    return FleetRobot(robot=robot, kind=None, state="unjudged", says=None, change=None)


def _robot_view(judged: Judged) -> FleetRobot:
    change, says = judged.change, None
    if judged.asked is not None:
        says = (
            f"{change.robot}: triage asks for the same diagnosis since {judged.asked.since}: "
            f"{judged.asked.effect} of {judged.asked.component}"
        )
    elif judged.state != "fine":
        says = of_robot(change)
    return FleetRobot(
        robot=change.robot,
        kind=change.kind,
        state=judged.state,
        says=says,
        change=Change.of(change),
    )
