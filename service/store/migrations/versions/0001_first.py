"""Vehicles, sessions, samples, recordings, jobs, keys and answers."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make all tables."""
    op.create_table(
        "vehicles",
        sa.Column("name", sa.String(100), primary_key=True),
        sa.Column("version", sa.Integer, primary_key=True),
        sa.Column("toml", sa.Text, nullable=False),
        sa.Column("origin", sa.String(200), nullable=False),
        sa.Column("created", sa.Double(), nullable=False),
    )
    op.create_table(
        "sessions",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("vehicle", sa.String(100), nullable=False),
        sa.Column("vehicle_version", sa.Integer, nullable=False),
        sa.Column("side", sa.Double(), nullable=False),
        sa.Column("runs", sa.Integer, nullable=False),
        sa.Column("how", sa.String(20), nullable=False),
        sa.Column("speed", sa.Double(), nullable=False),
        sa.Column("lifeline", sa.Double()),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("detail", sa.String(1000), nullable=False),
        *_ages("created", "changed", "expires"),
        sa.Column("revision", sa.Integer, nullable=False),
        sa.Column("result", sa.Text),
        sa.Column("pending", sa.Text),
        sa.Column("owner", sa.String(32)),
        sa.Column("lease", sa.Double()),
    )
    op.create_index("sessions_by_age", "sessions", ["created", "id"])
    op.create_index("sessions_by_state", "sessions", ["state"])
    op.create_table(
        "samples",
        sa.Column("session", sa.String(32), sa.ForeignKey("sessions.id"), primary_key=True),
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("direction", sa.String(3), nullable=False),
        sa.Column("errors", sa.Text, nullable=False),
        sa.Column("source", sa.String(200), nullable=False),
        sa.Column("recording", sa.String(32)),
        *_ages("created"),
    )
    op.create_table(
        "recordings",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("vehicle", sa.String(100), nullable=False),
        sa.Column("samples", sa.Integer, nullable=False),
        sa.Column("seconds", sa.Double(), nullable=False),
        sa.Column("laps", sa.Integer, nullable=False),
        sa.Column("poses", sa.Integer, nullable=False),
        sa.Column("size", sa.Integer, nullable=False),
        *_ages("created"),
        sa.Column("content", sa.LargeBinary, nullable=False),
    )
    op.create_index("recordings_by_age", "recordings", ["created", "id"])
    _jobs()
    op.create_table(
        "keys",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("name", sa.String(100), nullable=False),
        sa.Column("role", sa.String(20), nullable=False),
        sa.Column("secret", sa.String(64), nullable=False),
        *_ages("created"),
        sa.Column("revoked", sa.Double()),
    )
    op.create_table(
        "answers",
        sa.Column("caller", sa.String(16), primary_key=True),
        sa.Column("key", sa.String(200), primary_key=True),
        sa.Column("call", sa.String(400), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("status", sa.Integer, nullable=False),
        sa.Column("headers", sa.Text, nullable=False),
        sa.Column("body", sa.Text, nullable=False),
        *_ages("created"),
    )
    op.create_index("answers_by_age", "answers", ["created"])


def _jobs() -> None:
    op.create_table(
        "jobs",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("recordings", sa.Text, nullable=False),
        sa.Column("state", sa.String(20), nullable=False),
        sa.Column("progress", sa.Double(), nullable=False),
        sa.Column("doing", sa.String(200), nullable=False),
        sa.Column("verdict", sa.String(20)),
        sa.Column("says", sa.Text),
        sa.Column("error", sa.Text),
        sa.Column("attempts", sa.Integer, nullable=False),
        *_ages("created", "changed"),
        sa.Column("owner", sa.String(32)),
        sa.Column("lease", sa.Double()),
        sa.Column("result", sa.Text),
        sa.Column("report", sa.Text),
    )
    op.create_index("jobs_by_age", "jobs", ["created", "id"])
    op.create_index("jobs_by_state", "jobs", ["state"])


def _ages(*names: str) -> list[sa.Column[float]]:
    return [sa.Column(name, sa.Double(), nullable=False) for name in names]
