"""Findings: robots and places that daily reports name, from the first report that names them to the last.

A finding and the messages about it are written in one transaction, so neither is lost without the
other, whenever a service dies.
"""

from __future__ import annotations

import math
import time
from datetime import date
from typing import TYPE_CHECKING

from sqlalchemy import select

from omnimate.fleet.report import MIN_SEPARATION, describe_change, describe_place
from omnimate.service.fleets.models import Finding
from omnimate.service.fleets.webhooks import queue_message
from omnimate.service.store.tables import FindingRow, FleetRow, find_row

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy.orm import Session

    from omnimate.fleet.report import DailyReport

MAX_UNJUDGED_DAYS = 30  # after which the finding of a robot or floor that is no longer in use is closed


def note_findings(db: Session, fleet: str, report: DailyReport) -> None:
    """Open, prolong and close findings by a daily report; nothing where a later one was noted before.

    A report closes findings of robots and floors that it judges: of the others it says nothing, and their
    findings are closed when no report has judged them for `MAX_UNJUDGED_DAYS`.
    """
    row = find_row(db, FleetRow, fleet, for_change=True)
    if row.night is not None and report.day < row.night:
        return
    row.night = report.day
    opened = list(db.scalars(select(FindingRow).where(FindingRow.fleet == fleet, FindingRow.state == "open")))
    for named in _named(fleet, report):
        known = next((finding for finding in opened if _are_same(finding, named)), None)
        if known is None:
            db.add(named)
            _queue_messages(db, "finding.opened", named, report.day)
            continue
        opened.remove(known)
        known.says, known.last, known.changed = named.says, report.day, time.time()
        known.x, known.y = named.x, named.y
    for gone in opened:
        if not _is_judged(report, gone):
            if _days_between(gone.last, report.day) < MAX_UNJUDGED_DAYS:
                continue
            gone.says += f"; closed, as no report has judged it for {MAX_UNJUDGED_DAYS} days"
        gone.state, gone.changed = "closed", time.time()
        _queue_messages(db, "finding.closed", gone, report.day)


def go_back(db: Session, fleet: str, latest: str | None) -> None:
    """Have findings follow the reports after the latest one that is left; None where none is."""
    row = find_row(db, FleetRow, fleet, for_change=True)
    if row.night is not None and (latest is None or latest < row.night):
        row.night = latest


def _queue_messages(db: Session, what: str, finding: FindingRow, day: str) -> None:
    """Queue a message to the fleet's webhooks about a finding that a report opened or closed."""
    db.flush()
    view = Finding.of(finding).model_dump()
    queue_message(db, finding.fleet, {"type": what, "timestamp": day, "data": view})


def _named(fleet: str, report: DailyReport) -> Iterator[FindingRow]:
    """Yield a report's robots and places as new findings."""
    new = {"fleet": fleet, "first": report.day, "last": report.day}
    for change in report.faulty:
        says = describe_change(change)
        yield FindingRow(kind="robot", robot=change.robot, what=change.name, says=says, **new)
    for place in report.places:
        where = {"x": place.x, "y": place.y, "floor": place.floor}
        yield FindingRow(kind="place", what=place.effect, says=describe_place(place), **where, **new)


def _is_judged(report: DailyReport, finding: FindingRow) -> bool:
    """Return whether a report judges the robot or the floor of a finding."""
    if finding.kind == "robot":
        return any(change.robot == finding.robot for change in report.changes)
    return any(summary.floor == finding.floor for summary in report.floors)


def _days_between(first: str, last: str) -> int:
    return (date.fromisoformat(last) - date.fromisoformat(first)).days


def _are_same(finding: FindingRow, named: FindingRow) -> bool:
    """Return whether two findings are of one robot, or of places too near to be two."""
    if (finding.kind, finding.robot, finding.floor) != (named.kind, named.robot, named.floor):
        return False
    if finding.x is None or finding.y is None or named.x is None or named.y is None:
        return True
    return (
        finding.what == named.what and math.dist((finding.x, finding.y), (named.x, named.y)) < MIN_SEPARATION
    )
