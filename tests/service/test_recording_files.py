"""The files of recordings: there before their rows, deleted after them, taken from old rows."""

import sqlite3
import time
from contextlib import closing

import pytest
from sqlalchemy import create_engine, text

from omnimate.service.errors import NotFoundError
from omnimate.service.store.database import Database
from omnimate.service.store.recordings import CHECK_WAIT, DAY, RecordingStore, summarize
from omnimate.service.store.tables import RecordingContentRow, RecordingFileRow, RecordingRow
from tests.service.conftest import migrate, serving

LIMIT = 1_000_000


@pytest.fixture(scope="module")
def summary(small_recording):
    return summarize(small_recording)


@pytest.fixture
def database(tmp_path):
    database = Database(f"sqlite:///{tmp_path}/service.db")
    yield database
    database.close()


def stored(database, recording_id):
    with database.reading() as db:
        return db.get(RecordingRow, recording_id)


def test_files_without_a_row_are_deleted_a_day_later_and_no_others(database, summary, tmp_path):
    store = RecordingStore(database, f"{tmp_path}/files", LIMIT)
    acknowledged, orphan = store.add("a", b"zip", summary), store.add("b", b"zip", summary)
    acknowledged_id, now = acknowledged.id, time.time()
    with database.writing() as db:
        db.add(acknowledged)
    store.delete_orphans(now)
    assert store.content(orphan) == b"zip"
    another = tmp_path / "files" / "_recordings" / "0123.zip"
    another.write_bytes(b"of a service with another database")
    store.delete_orphans(now + 2.0 * DAY)
    assert another.exists()
    with pytest.raises(NotFoundError):
        store.content(orphan)
    assert store.content(stored(database, acknowledged_id)) == b"zip"


def test_a_recording_whose_file_is_deleted_is_not_there(database, summary, tmp_path):
    store = RecordingStore(database, str(tmp_path), LIMIT)
    row = store.add("a", b"zip", summary)
    store.delete(row.id)
    with pytest.raises(NotFoundError, match=row.id):
        store.read(row, summarize)


@pytest.mark.parametrize("dies_after", [0, 1, 2], ids=lambda count: f"dies after {count}")
def test_recordings_of_earlier_versions_are_moved_from_rows_into_files(dies_after, tmp_path, monkeypatch):
    """The service may die while it moves them, and goes on at the next start."""
    url = f"sqlite:///{tmp_path}/old.db"
    old_database(tmp_path / "old.db", {"one": b"first zip", "two": b"second zip"})
    database = Database(url)
    store = RecordingStore(database, f"{tmp_path}/files", LIMIT)
    moved = []

    def write(path, content, write=store._files.write):
        if len(moved) == dies_after:
            raise OSError("no space left")
        moved.append(path)
        write(path, content)

    if dies_after < 2:
        monkeypatch.setattr(store._files, "write", write)
        with pytest.raises(OSError, match="no space"):
            store.take_from_rows()
        monkeypatch.undo()
    store.take_from_rows()
    contents = {name: store.content(stored(database, name)) for name in ("one", "two")}
    assert contents == {"one": b"first zip", "two": b"second zip"}
    with database.reading() as db:
        assert db.query(RecordingContentRow).count() == 0
    database.close()


def old_database(path, contents):
    """Make a database of an earlier version."""
    engine = create_engine(f"sqlite:///{path}")
    with engine.begin() as connection:
        migrate(connection, "0003")
        for name, content in contents.items():
            connection.exec_driver_sql(
                "insert into recordings values (?, ?, 'omnimate', 1, 1.0, 0, 0, ?, 1e9, ?)",
                (name, name, len(content), content),
            )
    engine.dispose()


def test_a_service_that_could_store_no_recording_is_not_ready_until_it_can(database, tmp_path, monkeypatch):
    monkeypatch.setattr("omnimate.service.store.recordings.CHECK_PERIOD", 0.0)
    folder = tmp_path / "files" / "_recordings"
    with serving(str(database.engine.url), fleets=str(tmp_path / "files")) as client:
        assert list(folder.iterdir()) == []
        folder.rmdir()
        folder.write_bytes(b"no folder")
        answer = client.get("/readyz")
        assert (answer.status_code, "--fleets" in answer.json()["detail"]) == (503, True)
        folder.unlink()
        with database.writing() as db:
            assert db.query(RecordingFileRow).count() == 0
            db.execute(
                text(
                    "create trigger full before insert on recording_files begin select raise(abort, ''); end"
                )
            )
        answer = client.get("/readyz")
        assert (answer.status_code, "database cannot be written" in answer.json()["detail"]) == (503, True)
        with database.writing() as db:
            db.execute(text("drop trigger full"))
        assert client.get("/readyz").status_code == 200
        assert list(folder.iterdir()) == []


def test_a_service_whose_database_another_program_locks_says_so_before_the_caller_gives_up(
    database, tmp_path, monkeypatch
):
    assert CHECK_WAIT <= 1.0
    monkeypatch.setattr("omnimate.service.store.recordings.CHECK_PERIOD", 0.0)
    monkeypatch.setattr("omnimate.service.store.recordings.CHECK_WAIT", 0.0)
    with (
        serving(str(database.engine.url), fleets=str(tmp_path / "files")) as client,
        closing(sqlite3.connect(database.engine.url.database, isolation_level=None)) as other,
    ):
        other.execute("begin immediate")
        answer = client.get("/readyz")
        assert (answer.status_code, "another program may lock it" in answer.json()["detail"]) == (503, True)
        other.execute("rollback")
        monkeypatch.setattr("omnimate.service.store.recordings.CHECK_WAIT", 10.0)
        assert client.get("/readyz").status_code == 200


def test_a_check_that_succeeded_is_not_repeated_at_once(database, tmp_path):
    """Whoever asks often does not keep the disk busy."""
    store = RecordingStore(database, str(tmp_path / "files"), LIMIT)
    store.check()
    (tmp_path / "files" / "_recordings").rmdir()
    store.check()
    assert not (tmp_path / "files" / "_recordings").exists()
