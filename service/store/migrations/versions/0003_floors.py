"""Findings of places know their floor."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Add the floor; places that were named before are on the only one."""
    op.add_column("findings", sa.Column("floor", sa.String(64)))
    op.execute("UPDATE findings SET floor = '' WHERE kind = 'place'")
