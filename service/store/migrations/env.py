"""Run by Alembic: applies the steps on the connection that `omnimate.service.store.database` hands it."""

from __future__ import annotations

from alembic import context

from omnimate.service.store.tables import Base

context.configure(connection=context.config.attributes["connection"], target_metadata=Base.metadata)
context.run_migrations()
