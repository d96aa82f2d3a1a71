"""A fleet's results, as clients see them."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING

from omnimate.fleet.batch.tables import decode_columns
from omnimate.fleet.errors import FleetError
from omnimate.fleet.report import describe_change, describe_mismatch, describe_place
from omnimate.fleet.report_store import (
    find_latest_day,
    list_days,
    read_floor,
    read_history,
    read_report,
    read_robot,
)
from omnimate.fleet.segments import CELL
from omnimate.service.errors import NotFoundError
from omnimate.service.fleets import models

if TYPE_CHECKING:
    from typing import Any

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.report import BadPlace, DailyReport, JudgedRobot
    from omnimate.service.store.tables import FleetRow

LATEST = "latest"


def fleet_view(row: FleetRow, results: Files) -> models.Fleet:
    """Return a fleet with a summary of its latest report."""
    days, report = list_days(results), latest_report(results)
    states = Counter(sorted(robot.state for robot in robots_view(results, report)))
    return models.Fleet(
        name=row.id,
        created=row.created,
        nights=len(days),
        night=days[0] if days else None,
        states=dict(states),
        places=len(report.places) if report else 0,
    )


def latest_report(results: Files) -> DailyReport | None:
    """Return the latest report; None where there is none."""
    day = find_latest_day(results)
    return read_report(results, day) if day else None


def report_of(results: Files, day: str) -> DailyReport:
    """Return the report of a day, or the latest one; NotFoundError where there is none."""
    try:
        return read_report(results, None if day == LATEST else day)
    except FleetError as error:
        raise NotFoundError("night", day) from error


def report_view(report: DailyReport) -> models.FleetNight:
    """Return a daily report."""
    judged = {robot.change.robot: _robot_view(robot) for robot in report.judged() if robot.is_faulty}
    return models.FleetNight.of(
        report,
        judged=len(report.changes),
        sick=[judged[change.robot] for change in report.faulty],
        places=[_place_view(place) for place in report.places],
        asked=report.repeated,
        failed=[
            dict(zip(models.RecordingFailed.model_fields, failed, strict=True)) for failed in report.failed
        ],
    )


def _place_view(place: BadPlace) -> models.Place:
    return models.Place.of(place, says=describe_place(place))


def floor_view(results: Files, report: DailyReport, floor: str | None) -> models.FleetFloor:
    """Return a floor as of a daily report, by default that with most recordings; NotFoundError without it."""
    names = [summary.floor for summary in report.floors]
    name = names[0] if floor is None else floor
    if name not in names:
        raise NotFoundError("floor", name)
    driven = [(x, y, int(count)) for x, y, count in read_floor(results, report.day, name).tolist()]
    places = [_place_view(place) for place in report.places if place.floor == name]
    return models.FleetFloor(day=report.day, floor=name, cell=CELL, driven=driven, places=places)


def robots_view(results: Files, report: DailyReport | None) -> list[models.FleetRobot]:
    """Return all robots that have results, in the order of their names."""
    judged = {robot.change.robot: _robot_view(robot) for robot in report.judged()} if report else {}
    names = {path.rpartition("robot=")[2] for path in results.glob("recordings/robot=*")}
    return [judged.get(name) or _unjudged(name) for name in sorted(names | set(judged))]


def robot_view(results: Files, robot: str) -> models.FleetRobot:
    """Return a robot as of the latest report; NotFoundError where no recording of it has results."""
    if not results.glob(f"recordings/robot={robot}"):
        raise NotFoundError("robot", robot)
    judged = read_robot(results, robot)
    return _unjudged(robot) if judged is None else _robot_view(judged)


def history_view(results: Files, robot: str) -> models.FleetHistory:
    """Return a robot's history; NotFoundError where no recording of it has results."""
    courses = [models.FleetCourse.of(course) for course in read_history(results, robot)]
    return models.FleetHistory(robot=robot_view(results, robot), courses=courses)


def recordings_view(
    results: Files, robot: str, limit: int, after: str | None
) -> tuple[list[models.FleetRecording], str | None]:
    """Return a page of a robot's recordings, newest first, and the cursor of the next one, DAY_RECORDING."""
    paths = {
        f"{path.split('/')[2].removeprefix('day=')}_{path.split('/')[3].rpartition('-')[0]}": path
        for path in results.glob(f"recordings/robot={robot}/day=*/*.parquet")
    }
    cursors = sorted((cursor for cursor in paths if after is None or cursor < after), reverse=True)
    page = cursors[:limit]
    items = [_recording(cursor[:10], decode_columns(results.read(paths[cursor]))) for cursor in page]
    return items, page[-1] if len(cursors) > limit else None


def _recording(day: str, columns: dict[str, Any]) -> models.FleetRecording:
    row = {name: column[0] for name, column in columns.items()}
    whole = json.loads(row["diagnosis"])["says"] if row["diagnosis"] else None
    return models.FleetRecording(
        day=day, recording=row["recording"], duration=row["duration"], way=row["way"],
        triage=row["triage"], says=row["says"], diagnosis=whole, problem=row["error"],
    )  # fmt: skip


def _unjudged(robot: str) -> models.FleetRobot:
    return models.FleetRobot(robot=robot, kind=None, state="unjudged", says=None, change=None, asked=None)


def _robot_view(judged: JudgedRobot) -> models.FleetRobot:
    change, says = judged.change, None
    if judged.repeated is not None:
        says = describe_mismatch(judged.repeated)
    elif judged.state != "fine":
        says = describe_change(change)
    return models.FleetRobot.of(
        judged, robot=change.robot, kind=change.kind, says=says, asked=judged.repeated
    )
