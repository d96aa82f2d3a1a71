"""The queue of diagnoses: each job is worked on by one service at a time, and ends."""

import pytest

from omnimate.service.errors import NotFoundError, TooManyError
from omnimate.service.jobs.queue import MAX_UNFINISHED, add_job, cancel_job, claim_job, finish_job
from omnimate.service.store.tables import DiagnosisRow, JobRow, RecordingRow, find_row
from tests.service.conftest import recording_row

SUCCESS = {"verdict": "agreement", "says": "fine", "result": "{}", "report": "<html>"}


@pytest.fixture
def empty(database):
    """The database without jobs, and with a recording."""
    with database.writing() as db:
        db.query(JobRow).delete()
        db.query(RecordingRow).delete()
        db.add(recording_row())
    return database


def test_a_job_needs_recordings_that_are_there(empty):
    with empty.writing() as db, pytest.raises(NotFoundError, match="recording 'none'"):
        add_job(db, ["rec", "none"], "local")


def test_a_new_job_was_changed_when_it_was_created(empty):
    with empty.writing() as db:
        jobs = [add_job(db, ["rec"], "local") for _ in range(5)]
        assert [job.changed - job.created for job in jobs] == [0.0] * 5


def test_the_same_recordings_are_diagnosed_once(empty):
    with empty.writing() as db:
        db.get(RecordingRow, "rec").sha256 = "a" * 64
        first = add_job(db, ["rec"], "one")
        db.flush()
        assert claim_job(db, "this") == first.id
        assert add_job(db, ["rec"], "another").state == "queued"  # the first one has not ended
        finish_job(first, SUCCESS)
        first.verdict, first.result = SUCCESS["verdict"], SUCCESS["result"]
        db.flush()
        again = add_job(db, ["rec"], "another")
        assert (again.state, again.verdict, again.result) == ("done", "agreement", "{}")
        db.get(RecordingRow, "rec").sha256 = "b" * 64
        db.flush()
        assert add_job(db, ["rec"], "another").state == "queued"


def test_recordings_of_an_earlier_version_have_no_hash_and_are_diagnosed_each_time(empty):
    with empty.writing() as db:
        first = add_job(db, ["rec"], "one")
        finish_job(first, SUCCESS)
        db.flush()
        assert add_job(db, ["rec"], "one").state == "queued"


def test_a_key_that_has_queued_too_much_is_refused_and_others_are_not(empty):
    with empty.writing() as db:
        jobs = [add_job(db, ["rec"], "one").id for _ in range(MAX_UNFINISHED)]
        with pytest.raises(TooManyError, match="50 diagnoses of this key"):
            add_job(db, ["rec"], "one")
        add_job(db, ["rec"], "another")
        cancel_job(find_row(db, DiagnosisRow, jobs[0]))
        db.flush()
        add_job(db, ["rec"], "one")
