"""What the service remembers, in SQLite or PostgreSQL: nothing that was acknowledged is lost."""
