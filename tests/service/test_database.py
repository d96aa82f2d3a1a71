"""The database: its migrations make the tables that the code means, on both kinds."""

import sqlite3
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing

import pytest
import sqlalchemy
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy.exc import IntegrityError, SQLAlchemyError

from omnimate.service.store.database import BUSY_TIMEOUT, CONNECT_TIMEOUT, Database, DatabaseError
from omnimate.service.store.tables import Base, DeliveryRow, KeyRow, WebhookRow
from tests.service.conftest import migrate


def test_the_migrations_make_the_tables_of_the_code(database_url):
    database = Database(database_url)
    with database.engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Base.metadata) == []
    database.close()


VALUES = {"floor": "", "content": b"zip", "origin": "session 1"}  # on which later columns depend
DEFAULTS = {
    "jobs": {"kind": "diagnose", "priority": 0},
    "findings": {"floor": ""},
    "vehicles": {"session": "1"},
}  # of columns that are added


def rows_of(connection):
    """Return the only row of each table that has one."""
    tables = sqlalchemy.MetaData()
    tables.reflect(connection)
    return {
        table.name: dict(row)
        for table in tables.sorted_tables
        if table.name != "alembic_version"
        for row in connection.execute(table.select()).mappings()
    }


def fill(connection):
    """Add a row to each table, every column of it filled."""
    tables = sqlalchemy.MetaData()
    tables.reflect(connection)
    for table in tables.sorted_tables:
        if table.name != "alembic_version":
            row = {
                column.name: VALUES.get(column.name, "1" if column.type.python_type is str else 1)
                for column in table.columns
            }
            if table.name == "findings":
                row["kind"] = "place"
            connection.execute(table.insert().values(row))


@pytest.mark.parametrize("revision", ["0001", "0002", "0003", "0004", "0005", "0006", "0007", "0008"])
def test_the_rows_of_every_released_schema_are_in_the_newest_one(revision, database_url):
    engine = sqlalchemy.create_engine(database_url)
    with engine.begin() as connection:
        tables = sqlalchemy.MetaData()
        tables.reflect(connection)
        tables.drop_all(connection)
        migrate(connection, revision)
        fill(connection)
        before = rows_of(connection)
    Database(database_url).close()
    with engine.connect() as connection:
        after = rows_of(connection)
    engine.dispose()
    content = before["recordings"].pop("content", None)
    if content is not None:
        before["recording_contents"] = {"id": "1", "content": content}
    assert after.keys() == before.keys()
    for table, row in before.items():
        added = dict.fromkeys(after[table].keys() - row.keys()) | {
            name: value for name, value in DEFAULTS.get(table, {}).items() if name not in row
        }
        assert after[table] == row | added


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("https://bot:hunter2@hall.example:8080/a@b", "https://hall.example:8080/a@b"),
        ("https://bot:hun@ter2@hall.example/", "https://hall.example/"),
        ("https://bot:hunter2@[::1/", "https://[::1/"),
        ("https://hall.example/to?mail=a@b", "https://hall.example/to?mail=a@b"),
    ],
)
def test_a_password_in_the_url_of_a_webhook_of_an_earlier_version_is_removed(url, shown, tmp_path):
    database_url = f"sqlite:///{tmp_path}/old.db"
    engine = sqlalchemy.create_engine(database_url)
    with engine.begin() as connection:
        migrate(connection, "0007")
        connection.exec_driver_sql("insert into fleets (id, created) values ('hall', 1)")
        connection.exec_driver_sql("insert into webhooks values ('1', 'hall', ?, 'whsec_', 1)", (url,))
        connection.exec_driver_sql(
            "insert into deliveries values ('1', '1', '{}', 'waiting', 1, 1, 'no port: hunter2', 1, 1)"
        )
    engine.dispose()
    database = Database(database_url)
    with database.reading() as db:
        assert db.query(WebhookRow).one().url == shown
        assert db.query(DeliveryRow).one().answer == (None if shown != url else "no port: hunter2")
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
        ("sqlite://", "in memory"),
        ("sqlite:///:memory:", "in memory"),
        (f"sqlite:///{__file__}", "cannot be opened: file is not a database"),
        ("postgresql+psycopg://nobody@127.0.0.1:1/x", "cannot be opened"),
    ],
)
def test_a_database_that_cannot_be_used_says_why(url, words):
    with pytest.raises(DatabaseError, match=words):
        Database(url)


@pytest.mark.parametrize(("query", "timeout"), [("", CONNECT_TIMEOUT), ("?connect_timeout=3", "3")])
def test_a_server_that_does_not_answer_is_waited_for_so_long(query, timeout, monkeypatch):
    psycopg = pytest.importorskip("psycopg")
    asked = []

    def connect(*_arguments, **options):
        asked.append(options)
        raise psycopg.OperationalError("no answer")

    monkeypatch.setattr("psycopg.connect", connect)
    with pytest.raises(DatabaseError):
        Database(f"postgresql+psycopg://robot@192.0.2.1/fleet{query}")
    assert asked[0]["connect_timeout"] == timeout


def test_a_database_of_a_newer_version_is_refused_and_left_as_it_is(tmp_path):
    url = f"sqlite:///{tmp_path}/newer.db"
    Database(url).close()
    engine = sqlalchemy.create_engine(url)
    with engine.begin() as connection:
        connection.execute(sqlalchemy.text("update alembic_version set version_num = '9999'"))
    with pytest.raises(DatabaseError, match="newer version of omnimate; expected that version, or a backup"):
        Database(url)
    with engine.connect() as connection:
        assert connection.scalar(sqlalchemy.text("select version_num from alembic_version")) == "9999"
    engine.dispose()


def test_calls_one_after_the_other_use_one_connection_however_many_are_open(database):
    """Each connection that is used fills a cache of pages."""
    with database.engine.connect(), database.engine.connect(), database.engine.connect():
        pass
    used = set()
    for _ in range(3):
        with database.engine.connect() as connection:
            used.add(id(connection.connection.dbapi_connection))
    assert len(used) == 1


def test_all_open_connections_together_cache_no_more_pages_than_one_does_by_default(database):
    """Each cache fills as the database grows, and stays full while its connection is not used."""
    size = sqlalchemy.text("PRAGMA cache_size")
    with ExitStack() as calls:
        count = database.engine.pool.size()
        connections = [calls.enter_context(database.engine.connect()) for _ in range(count)]
        sizes = [-connection.scalar(size) for connection in connections]
    with sqlalchemy.create_engine("sqlite://").connect() as default:
        assert 0 < sum(sizes) <= -default.scalar(size)


def test_calls_that_wait_for_a_locked_database_do_not_wait_one_after_the_other(database):
    timeout, callers = 0.2, 8

    def refused(_number):
        """Return how long a write waited [s] before it was refused."""
        start = time.monotonic()
        with pytest.raises(SQLAlchemyError), database.writing(timeout) as db:
            db.execute(sqlalchemy.text("select 1"))
        return time.monotonic() - start

    with closing(sqlite3.connect(database.engine.url.database, isolation_level=None)) as other:
        other.execute("begin immediate")
        alone = refused(0)
        with ThreadPoolExecutor(callers) as threads:
            together = max(threads.map(refused, range(callers)))
        other.execute("rollback")
    assert alone >= timeout
    assert together < callers / 2 * alone
    with database.writing() as db:
        assert db.scalar(sqlalchemy.text("PRAGMA busy_timeout")) == 1000 * BUSY_TIMEOUT
