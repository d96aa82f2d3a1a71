"""Recordings know what of their log could not be read."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Add the column; it is unknown of former recordings."""
    op.add_column("recordings", sa.Column("problems", sa.Text))
