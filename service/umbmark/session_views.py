"""Sessions and their runs as clients see them."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from sqlalchemy import func, select

from omnimate.service.store.tables import SampleRow
from omnimate.service.umbmark.models import Counts, Sample, Session
from omnimate.service.umbmark.sessions import possible_calls, state_of

if TYPE_CHECKING:
    from collections.abc import Iterable

    from sqlalchemy.orm import Session as Db

    from omnimate.service.store.tables import SessionRow


def session_view(row: SessionRow, counts: Counts, samples: list[Sample] | None = None) -> Session:
    """Return a session as clients see it."""
    now = time.time()
    progress = f"cw {counts.cw} of {row.runs}, ccw {counts.ccw} of {row.runs}"
    return Session.model_validate(
        {
            "id": row.id, "vehicle": row.vehicle, "vehicle_version": row.vehicle_version, "side": row.side,
            "runs": row.runs, "how": row.how, "state": state_of(row, now), "detail": row.detail or progress,
            "possible": list(possible_calls(row, now)), "created": row.created, "changed": row.changed,
            "expires": row.expires, "counts": counts, "samples": samples,
        }
    )  # fmt: skip


def session_with_samples(db: Db, row: SessionRow) -> Session:
    """Return a session with its runs."""
    db.flush()
    return session_view(row, count_samples(db, [row.id])[row.id], samples_of(db, row))


def count_samples(db: Db, session_ids: Iterable[str]) -> dict[str, Counts]:
    """Return the number of runs in each direction, by the id of the session."""
    counts = {session_id: Counts(cw=0, ccw=0) for session_id in session_ids}
    query = (
        select(SampleRow.session, SampleRow.direction, func.count())
        .where(SampleRow.session.in_(counts))
        .group_by(SampleRow.session, SampleRow.direction)
    )
    for session_id, direction, number in db.execute(query):
        setattr(counts[session_id], direction, number)
    return counts


def samples_of(db: Db, row: SessionRow) -> list[Sample]:
    """Return the runs of a session in the order of their numbers."""
    rows = db.scalars(select(SampleRow).where(SampleRow.session == row.id).order_by(SampleRow.number))
    return [sample_view(sample) for sample in rows]


def sample_view(row: SampleRow) -> Sample:
    """Return a run as clients see it."""
    return Sample.model_validate(row, from_attributes=True)
