"""Lists that are read page by page, newest first."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from sqlalchemy import select, tuple_

from service.errors import NotThereError
from service.store.tables import JobRow, RecordingRow, SessionRow

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement
    from sqlalchemy.orm import Session

Listed = TypeVar("Listed", SessionRow, RecordingRow, JobRow)


def page(
    db: Session, table: type[Listed], limit: int, after: str | None, *where: ColumnElement[bool]
) -> tuple[list[Listed], str | None]:
    """Return up to `limit` rows that come after the one of the cursor, and the next cursor or None.

    Raises:
        NotThereError: the cursor is of no row.
    """
    query = select(table).where(*where).order_by(table.created.desc(), table.id.desc()).limit(limit + 1)
    if after is not None:
        last = db.get(table, after)
        if last is None:
            raise NotThereError("row of the cursor", after)
        query = query.where(tuple_(table.created, table.id) < tuple_(last.created, last.id))
    rows = list(db.scalars(query))
    more = len(rows) > limit
    return rows[:limit], rows[limit - 1].id if more else None
