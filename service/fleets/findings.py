"""Findings: what nights' lists name, from the first night that names it to the last.

A finding and the messages about it are written in one transaction, so neither is lost without the
other, whenever a service dies.
"""

from __future__ import annotations

import math
import secrets
import time
from typing import TYPE_CHECKING

from sqlalchemy import select

from omnimate.fleet.morning import SEPARATE
from omnimate.fleet.words import of_place, of_robot
from omnimate.service.fleets.models import Finding
from omnimate.service.fleets.webhooks import queue_message
from omnimate.service.store.rows import find_row
from omnimate.service.store.tables import FindingRow, FleetRow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy.orm import Session

    from omnimate.fleet.morning import BadPlace, Morning


def note_findings(db: Session, fleet: str, morning: Morning) -> None:
    """Open, prolong and close findings by a night's list; nothing where a later night was noted before."""
    row = find_row(db, FleetRow, fleet, for_change=True)
    if row.night is not None and morning.day < row.night:
        return
    row.night = morning.day
    opened = list(db.scalars(select(FindingRow).where(FindingRow.fleet == fleet, FindingRow.state == "open")))
    for named in _named(fleet, morning):
        known = next((finding for finding in opened if _are_same(finding, named)), None)
        if known is None:
            db.add(named)
            _queue_messages(db, "finding.opened", named, morning.day)
            continue
        opened.remove(known)
        known.says, known.last, known.changed = named.says, morning.day, named.changed
        known.x, known.y = named.x, named.y
    for gone in opened:
        gone.state, gone.changed = "closed", time.time()
        _queue_messages(db, "finding.closed", gone, morning.day)


def _queue_messages(db: Session, what: str, finding: FindingRow, night: str) -> None:
    """Queue a message to the fleet's webhooks about a finding that a night opened or closed."""
    db.flush()
    view = Finding.of(finding).model_dump()
    queue_message(db, finding.fleet, {"type": what, "timestamp": night, "data": view})


def _named(fleet: str, morning: Morning) -> Iterator[FindingRow]:
    """Yield a night's list as new findings."""
    for change in morning.sick:
        yield _finding(fleet, morning.day, "robot", change.name, of_robot(change), robot=change.robot)
    for place in morning.places:
        yield _finding(fleet, morning.day, "place", place.effect, of_place(place), place=place)


def _finding(
    fleet: str,
    day: str,
    kind: str,
    what: str,
    says: str,
    *,
    robot: str | None = None,
    place: BadPlace | None = None,
) -> FindingRow:
    now = time.time()
    x, y, floor = (place.x, place.y, place.floor) if place else (None, None, None)
    return FindingRow(
        id=secrets.token_hex(8), fleet=fleet, kind=kind, state="open", robot=robot, what=what, x=x, y=y,
        floor=floor, says=says, first=day, last=day, created=now, changed=now,
    )  # fmt: skip


def _are_same(finding: FindingRow, named: FindingRow) -> bool:
    """Return whether a night names again what a finding is about: the robot, or a place as near as one."""
    if (finding.kind, finding.robot, finding.floor) != (named.kind, named.robot, named.floor):
        return False
    if finding.x is None or finding.y is None or named.x is None or named.y is None:
        return True
    return finding.what == named.what and math.dist((finding.x, finding.y), (named.x, named.y)) < SEPARATE
