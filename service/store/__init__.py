"""The database, SQLite or PostgreSQL: nothing that was acknowledged is lost."""
