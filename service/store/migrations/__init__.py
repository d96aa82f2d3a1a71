"""The migrations that make the tables, step by step (Alembic)."""
