"""Fleets, their batches among the jobs, findings, webhooks and deliveries."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Make the tables of fleets, and let a job be a batch."""
    op.add_column("jobs", sa.Column("kind", sa.String(20), nullable=False, server_default="diagnose"))
    op.add_column("jobs", sa.Column("fleet", sa.String(64)))
    op.add_column("jobs", sa.Column("asked", sa.Text))
    op.add_column("jobs", sa.Column("summary", sa.Text))
    op.add_column("jobs", sa.Column("priority", sa.Integer, nullable=False, server_default="0"))
    op.create_table(
        "fleets",
        sa.Column("id", sa.String(64), primary_key=True),
        _age("created"),
        sa.Column("night", sa.String(10)),
    )
    op.create_table(
        "findings",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("fleet", sa.String(64), sa.ForeignKey("fleets.id"), nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("robot", sa.String(100)),
        sa.Column("what", sa.String(40), nullable=False),
        sa.Column("x", sa.Double()),
        sa.Column("y", sa.Double()),
        sa.Column("says", sa.Text, nullable=False),
        sa.Column("first", sa.String(10), nullable=False),
        sa.Column("last", sa.String(10), nullable=False),
        _age("created"),
        _age("changed"),
    )
    op.create_index("findings_by_fleet", "findings", ["fleet", "state"])
    op.create_table(
        "webhooks",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("fleet", sa.String(64), sa.ForeignKey("fleets.id"), nullable=False),
        sa.Column("url", sa.String(1000), nullable=False),
        sa.Column("secret", sa.String(100), nullable=False),
        _age("created"),
    )
    op.create_table(
        "deliveries",
        sa.Column("id", sa.String(40), primary_key=True),
        sa.Column("webhook", sa.String(32), nullable=False),
        sa.Column("body", sa.Text, nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("attempts", sa.Integer, nullable=False),
        _age("due"),
        sa.Column("answer", sa.String(200)),
        _age("created"),
        _age("changed"),
    )
    op.create_index("deliveries_due", "deliveries", ["state", "due"])
    for table in ("fleets", "findings", "webhooks", "deliveries"):
        op.create_index(f"{table}_by_age", table, ["created", "id"])


def _age(name: str) -> sa.Column[float]:
    return sa.Column(name, sa.Double(), nullable=False)
