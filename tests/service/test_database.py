"""The database: its migrations make the tables that the code means, on both kinds."""

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy.exc import IntegrityError

from omnimate.service.store.database import Database, DatabaseError
from omnimate.service.store.tables import Base, KeyRow


def test_the_migrations_make_the_tables_of_the_code(database_url):
    database = Database(database_url)
    with database.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []
    database.close()


def test_a_change_is_made_whole_or_not_at_all(database_url):
    database = Database(database_url)

    def key(name):
        return KeyRow(id=name, name="x", role="read", secret="", created=0.0)

    def change():
        with database.writing() as db:
            db.add(key("one"))
            db.flush()
            db.add_all([key("two"), key("two")])

    with pytest.raises(IntegrityError):
        change()
    with database.reading() as db:
        assert db.get(KeyRow, "one") is None
    database.close()


@pytest.mark.parametrize(
    ("url", "words"),
    [
        ("sqlite:////no/such/folder/x.db", "cannot be opened"),
        ("mysql://root@localhost/x", "of another kind"),
        ("nonsense", "no URL"),
        ("postgresql+psycopg://nobody@127.0.0.1:1/x", "cannot be opened"),
    ],
)
def test_a_database_that_cannot_be_used_says_why(url, words):
    with pytest.raises(DatabaseError, match=words):
        Database(url)
