"""The database: one writer at a time in SQLite, row locks in PostgreSQL, migrations at the start."""

from __future__ import annotations

import math
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from alembic import command
from alembic.config import Config
from alembic.util import CommandError
from sqlalchemy import create_engine, event, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError, DisconnectionError
from sqlalchemy.exc import TimeoutError as LockTimeout
from sqlalchemy.orm import Session
from sqlalchemy.pool import QueuePool

from omnimate.service.errors import ServiceError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from sqlalchemy.engine import Connection, Engine
    from sqlalchemy.pool import ConnectionPoolEntry

MIGRATIONS = Path(__file__).with_name("migrations")
BUSY_TIMEOUT = 10.0  # [s] for other threads and processes to finish their writes
POOLED = 20  # connections that stay open
CACHE = 2000 // POOLED  # [KiB] of pages in each; 2000 are SQLite's default for one (PRAGMA cache_size)
CONNECT_TIMEOUT = 10  # [s] for a server of PostgreSQL to answer, unless its URL says `connect_timeout`
IDLE_TIME = 1.0  # [s] after which a connection is tested before it is used
MIGRATION_LOCK = 0x6F6D6E69  # number of the lock under which PostgreSQL's tables are changed


class DatabaseError(ServiceError):
    """A database that cannot be used; its URL is without the password."""

    def __init__(
        self,
        url: str,
        problem: str,
        expected: str = "sqlite:///file.db or postgresql+psycopg://user@host/name",
    ) -> None:
        super().__init__(f"database {url}: {problem}; expected {expected}")
        self.url = url


class Database:
    """A database with its tables as this version of the service needs them."""

    def __init__(self, url: str, *, existing: bool = False) -> None:
        """Connect and bring the tables up to date; DatabaseError where that cannot be done.

        A file of SQLite that is not there is made, or refused if it has to be `existing`.
        """
        shown, self.engine = _engine(url)
        sqlite = self.engine.dialect.name == "sqlite"
        file = self.engine.url.database or ""
        if existing and sqlite and not file.startswith("file:") and not Path(file).is_file():
            raise DatabaseError(shown, "there is no such file")
        self._write_lock = threading.Lock() if sqlite else None
        self._reader = self.engine if sqlite else self.engine.execution_options(isolation_level="AUTOCOMMIT")
        try:
            with self.engine.execution_options(immediate=BUSY_TIMEOUT).begin() as connection:
                _migrate(connection)
        except DBAPIError as error:  # also of a file that is no database
            raise DatabaseError(shown, f"cannot be opened: {error.orig}") from error
        except CommandError as error:  # its revision is unknown here
            raise DatabaseError(
                shown,
                "it was made or changed by a newer version of omnimate",
                "that version, or a backup from before it",
            ) from error

    def reading(self) -> Session:
        """Return a session for reading, which ends with its block."""
        return Session(self._reader)

    @contextmanager
    def writing(self, timeout: float = BUSY_TIMEOUT) -> Iterator[Session]:
        """Yield a session whose changes are all committed durably at the end, or none of them.

        With SQLite, SQLAlchemyError where others write for longer than the timeout [s]: threads of this
        process and other processes together, so that calls do not wait for each other's timeouts.
        """
        end = time.monotonic() + timeout
        with self._turn_to_write(timeout):
            left = max(0.0, end - time.monotonic())
            with Session(self.engine.execution_options(immediate=left)) as session, session.begin():
                yield session

    @contextmanager
    def _turn_to_write(self, timeout: float) -> Iterator[None]:
        """Hold the lock under which one thread at a time writes to SQLite."""
        if self._write_lock is None:
            yield
            return
        if not self._write_lock.acquire(timeout=timeout):
            raise LockTimeout(f"other calls have written to the database for {timeout:g} s")
        try:
            yield
        finally:
            self._write_lock.release()

    def check(self) -> None:
        """Check that the database answers; SQLAlchemyError where it does not."""
        with self.engine.connect() as connection:
            connection.execute(text("select 1"))

    def close(self) -> None:
        """Close all connections."""
        self.engine.dispose()


def _engine(url: str) -> tuple[str, Engine]:
    try:
        parsed = make_url(url)
        shown = parsed.render_as_string(hide_password=True)
        if parsed.get_backend_name() not in {"sqlite", "postgresql"}:
            raise DatabaseError(shown, "of another kind")
        if parsed.get_backend_name() == "sqlite" and parsed.database in {None, "", ":memory:"}:
            raise DatabaseError(shown, "in memory, where each connection has another one")
        server = parsed.get_backend_name() != "sqlite" and "connect_timeout" not in parsed.query
        # Last in, first out: few connections cache pages and statements.
        engine = create_engine(
            parsed,
            connect_args={"connect_timeout": CONNECT_TIMEOUT} if server else {},
            poolclass=QueuePool,
            pool_size=POOLED,
            max_overflow=40,
            pool_use_lifo=True,
            hide_parameters=True,  # secrets of webhooks are among them, and errors are logged
        )
    except ArgumentError as error:
        raise DatabaseError("(as given)", f"no URL: {error}") from error
    except ModuleNotFoundError as error:
        raise DatabaseError(
            shown, f"{error.name} is not installed: pip install 'omnimate[postgresql]'"
        ) from error
    if engine.dialect.name == "sqlite":
        event.listen(engine, "connect", _on_connect)
        event.listen(engine, "begin", _on_begin)
    else:
        event.listen(engine, "checkin", _on_checkin)
        event.listen(engine, "checkout", _on_checkout)
    return shown, engine


def _on_connect(connection: Any, _record: object) -> None:  # noqa: ANN401  # of the driver
    """Let readers work at the same time as the writer; a commit returns when it is on the disk.

    Few pages are cached: a commit of another connection makes them void, and the system caches the file.
    """
    connection.isolation_level = None  # transactions begin where `_on_begin` says
    timeout, cache = f"busy_timeout={int(1000 * BUSY_TIMEOUT)}", f"cache_size={-CACHE}"
    for pragma in ("journal_mode=WAL", "synchronous=FULL", timeout, cache):
        connection.execute(f"PRAGMA {pragma}")


def _on_checkin(_connection: object, record: ConnectionPoolEntry) -> None:
    """Note when a connection was used last."""
    record.info["used"] = time.monotonic()


def _on_checkout(connection: Any, record: ConnectionPoolEntry, _proxy: object) -> None:  # noqa: ANN401
    """Test a connection that was idle: the server may have been restarted since. The pool connects again."""
    if time.monotonic() - record.info.get("used", math.inf) > IDLE_TIME:
        try:
            connection.execute("select 1")
            connection.rollback()
        except connection.Error as error:
            raise DisconnectionError(str(error)) from error


def _on_begin(connection: Connection) -> None:
    """Begin; a writer takes the lock at once, so that it never has to give up in the middle.

    It waits for the lock for the seconds that the option `immediate` has.
    """
    wait = connection.get_execution_options().get("immediate")
    if wait is None:
        connection.exec_driver_sql("BEGIN")
        return
    _set_busy_timeout(connection, wait)
    try:
        connection.exec_driver_sql("BEGIN IMMEDIATE")
    finally:
        _set_busy_timeout(connection, BUSY_TIMEOUT)


def _set_busy_timeout(connection: Connection, seconds: float) -> None:
    """Set how long a connection of SQLite waits for the locks of others."""
    connection.exec_driver_sql(f"PRAGMA busy_timeout={int(1000 * seconds)}").close()


def _migrate(connection: Connection) -> None:
    if connection.dialect.name == "postgresql":
        connection.execute(text("select pg_advisory_xact_lock(:lock)"), {"lock": MIGRATION_LOCK})
    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
