"""Versions of vehicles know the session and the key that they come from."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Add the columns; the session is known from the origin in words, the key of former versions is not."""
    op.add_column("vehicles", sa.Column("session", sa.String(32)))
    op.add_column("vehicles", sa.Column("made_by", sa.String(100)))
    op.execute(
        "UPDATE vehicles SET session = (SELECT id FROM sessions WHERE 'session ' || id = vehicles.origin)"
    )
