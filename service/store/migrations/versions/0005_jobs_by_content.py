"""Recordings have a hash, and jobs that of what they work on, so that nothing is computed twice."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Add the columns; what is there already stays without a hash, and without a caller."""
    op.add_column("recordings", sa.Column("sha256", sa.String(64)))
    op.add_column("jobs", sa.Column("caller", sa.String(16)))
    op.add_column("jobs", sa.Column("content", sa.String(64)))
    op.create_index("jobs_by_content", "jobs", ["content"])
