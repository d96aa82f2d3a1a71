"""The contents of recordings leave their rows; the service's start moves them from here into files."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Put the contents into a table of their own, which is empty after the service's next start."""
    op.create_table(
        "recording_files",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("created", sa.Double(), nullable=False),
    )
    op.create_table(
        "recording_contents",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("content", sa.LargeBinary, nullable=False),
    )
    op.execute("INSERT INTO recording_contents (id, content) SELECT id, content FROM recordings")
    op.drop_column("recordings", "content")
