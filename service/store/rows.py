"""Rows that are found by their key, and lists that are read page by page, newest first."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from sqlalchemy import select, tuple_

from omnimate.service.errors import NotFoundError

if TYPE_CHECKING:
    from sqlalchemy import ColumnElement
    from sqlalchemy.orm import Session

    from omnimate.service.store.tables import ListedRow

Row = TypeVar("Row", bound="ListedRow")


def find_row(db: Session, table: type[Row], key: str, *, for_change: bool = False, **having: object) -> Row:
    """Return the row of a table with a key, and with the values that it is `having`.

    `for_change` locks it until the end of the transaction.

    Raises:
        NotFoundError: there is no such row.
    """
    row = db.get(table, key, with_for_update=for_change)
    if row is None or any(getattr(row, name) != value for name, value in having.items()):
        raise NotFoundError(table.__tablename__.removesuffix("s"), key)
    return row


def read_page(
    db: Session, table: type[Row], limit: int, after: str | None, *where: ColumnElement[bool]
) -> tuple[list[Row], str | None]:
    """Return a page of rows and the cursor of the next page, which is None after the last one.

    `after` is the cursor, the id of the row before the page; None for the first page.

    Raises:
        NotFoundError: there is no row with the cursor's id.
    """
    query = select(table).where(*where).order_by(table.created.desc(), table.id.desc()).limit(limit + 1)
    if after is not None:
        last = db.get(table, after)
        if last is None:
            raise NotFoundError("row of the cursor", after)
        query = query.where(tuple_(table.created, table.id) < tuple_(last.created, last.id))
    rows = list(db.scalars(query))
    more = len(rows) > limit
    return rows[:limit], rows[limit - 1].id if more else None
