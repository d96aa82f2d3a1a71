"""Rows that are found by their key."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from omnimate.service.errors import NotFoundError
from omnimate.service.store.tables import FleetRow, KeyRow, RecordingRow, SessionRow, WebhookRow

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

Found = TypeVar("Found", FleetRow, KeyRow, RecordingRow, SessionRow, WebhookRow)
_NOUNS: dict[type, str] = {
    FleetRow: "fleet",
    KeyRow: "key",
    RecordingRow: "recording",
    SessionRow: "session",
    WebhookRow: "webhook",
}


def find_row(
    db: Session, table: type[Found], key: str, *, for_change: bool = False, **having: object
) -> Found:
    """Return the row of a table with a key; `for_change` locks it until the end of the transaction.

    Args:
        db: The open transaction.
        table: The table.
        key: The row's key.
        for_change: Whether the row is locked.
        **having: Values that columns of the row have, such as the fleet of a webhook.

    Raises:
        NotFoundError: there is no such row.
    """
    row = db.get(table, key, with_for_update=for_change)
    if row is None or any(getattr(row, name) != value for name, value in having.items()):
        raise NotFoundError(_NOUNS[table], key)
    return row
