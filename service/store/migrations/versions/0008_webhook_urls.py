"""URLs of webhooks are without user and password, which everyone who may read would see."""

from __future__ import annotations

from urllib.parse import urlsplit

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Remove them, and the answers to messages, which quote them: no message could be sent to such a URL."""
    connection = op.get_bind()
    rows = connection.execute(sa.text("SELECT id, url FROM webhooks WHERE url LIKE '%@%'")).all()
    for identity, url in rows:
        try:
            netloc = urlsplit(url).netloc
        except ValueError:  # brackets without an IPv6 address between them
            netloc = url.partition("//")[2].partition("/")[0]
        if "@" not in netloc:
            continue
        changed = {"id": identity, "url": url.replace(netloc, netloc.rpartition("@")[2], 1)}
        connection.execute(sa.text("UPDATE webhooks SET url = :url WHERE id = :id"), changed)
        connection.execute(sa.text("UPDATE deliveries SET answer = NULL WHERE webhook = :id"), changed)
