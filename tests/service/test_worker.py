"""Diagnoses as jobs: done in a process of their location, retried when it dies, never stuck."""

import multiprocessing
import threading
import time
from contextlib import contextmanager

import pytest
from sqlalchemy import select

from omnimate.service.jobs import worker
from omnimate.service.store.tables import JobRow, RecordingRow, SessionRow
from tests.service.conftest import PATIENCE, short_zip, started, until, uploaded

PATH = "/v1/diagnoses"
ENDED = {"done", "failed", "cancelled"}


@pytest.fixture(scope="module")
def recording(client):
    """The id of a recording that is too short to diagnose anything from."""
    return uploaded(client, short_zip(0.5))


@pytest.fixture
def undiagnosed(client, recording):
    """The recording without the hash by which its diagnosis would be found again."""
    with client.components.database.writing() as db:
        db.get(RecordingRow, recording).sha256 = None
    return recording


def test_a_diagnosis_is_done_and_can_be_read(client, recording):
    made = client.post(PATH, json={"recordings": [recording]})
    assert made.status_code == 202
    location = made.headers["Location"]
    assert client.get(f"{location}/result").status_code in {200, 409}
    until(lambda: client.get(location).json()["state"] in ENDED)
    job = client.get(location).json()
    assert (job["state"], job["progress"]) == ("done", 1.0)
    assert client.get(f"{location}/result").json()["verdict"] == job["verdict"]
    report = client.get(f"{location}/report")
    assert "<html" in report.text
    assert "sandbox" in report.headers["content-security-policy"]
    again = client.post(PATH, json={"recordings": [recording]})
    assert (again.json()["state"], again.json()["attempts"]) == ("done", 0)
    assert client.get(f"{again.headers['Location']}/report").text == report.text


def test_what_its_process_dies_of_is_tried_again_and_then_given_up(client, undiagnosed):
    location = client.post(PATH, json={"recordings": [undiagnosed]}).headers["Location"]

    def killed():
        for child in multiprocessing.active_children():
            child.kill()
        return client.get(location).json()["state"] in ENDED

    until(killed)
    job = client.get(location).json()
    assert (job["state"], job["attempts"]) == ("failed", 3)
    assert job["error"].startswith("given up after 3 attempts: its process ended with code ")


@pytest.fixture
def ended(client):
    """Return a function that makes a diagnosis, which begins once `meanwhile` was called, and returns it."""

    def run(recordings, meanwhile=lambda: None):
        with nothing_claimed():
            location = client.post(PATH, json={"recordings": recordings}).headers["Location"]
            meanwhile()
        return until(lambda: (job := client.get(location).json())["state"] in ENDED and job)

    return run


@contextmanager
def nothing_claimed():
    """Let no worker claim a job."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(worker, "has_queued", lambda _db, _table: False)
        yield


@pytest.mark.parametrize("others", [0, 1])
def test_a_diagnosis_fails_if_a_recording_was_deleted_before_it_and_is_made_when_it_is_back(
    client, recording, ended, others
):
    def wanted():
        return [*[recording][:others], uploaded(client, short_zip(0.6))]

    first = wanted()
    job = ended(first, lambda: client.delete(f"/v1/recordings/{first[-1]}"))
    assert (job["state"], job["attempts"]) == ("failed", 1)
    assert job["error"].startswith(f"recording {first[-1]} was deleted before it was diagnosed;")
    again = ended(wanted())
    assert (again["state"], again["attempts"]) == ("done", 1)


def test_a_diagnosis_fails_if_the_file_of_a_recording_is_deleted_before_it_is_read(client, ended):
    """The row goes first: a worker may find it, and the file no more."""
    unread = uploaded(client, short_zip(0.7))
    job = ended([unread], lambda: client.components.recordings.delete(unread))
    assert (job["state"], "was deleted" in job["error"]) == ("failed", True)


def test_a_job_that_cannot_start_fails_at_once_with_a_sentence(client, undiagnosed, ended, monkeypatch):
    def start(*_arguments):
        raise PermissionError("/srv/secret")

    monkeypatch.setattr(client.components.worker, "start_job", start)
    job = ended([undiagnosed])
    assert (job["state"], job["attempts"]) == ("failed", 1)
    assert job["error"] == "the diagnosis could not start: PermissionError; the log of the service says more"


def test_what_a_dead_service_drove_is_interrupted_also_while_a_diagnosis_runs(client, undiagnosed):
    """A long diagnosis left the session `driving`, without a robot that drives, until it had ended."""
    drive, may_begin = started(client, vehicle="omnimate"), threading.Event()

    def start(*_arguments):
        may_begin.wait(PATIENCE)
        raise PermissionError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(client.components.worker, "start_job", start)
        location = client.post(PATH, json={"recordings": [undiagnosed]}).headers["Location"]
        until(lambda: client.get(location).json()["state"] == "running")
        try:
            with client.components.database.writing() as db:
                row = db.get(SessionRow, drive.rpartition("/")[2])
                row.state, row.owner, row.lease = "driving", "dead", time.time() - 1.0
            until(lambda: client.get(drive).json()["state"] == "interrupted")
            assert client.get(drive).json()["detail"].endswith("or could not write to the database")
            assert client.get(location).json()["state"] == "running"
        finally:
            may_begin.set()
            until(lambda: client.get(location).json()["state"] in ENDED)


def test_a_lease_is_renewed_after_each_recording_that_is_unpacked(client, ended, monkeypatch):
    """Several large recordings take longer than a lease, after which the job was taken from its service."""
    store, leases = client.components.recordings, []
    unpack = store.unpack

    def note_lease(*arguments):
        with client.components.database.reading() as db:
            leases.append(db.scalars(select(JobRow.lease).where(JobRow.state == "running")).one())
        return unpack(*arguments)

    monkeypatch.setattr(worker, "REPORT_PERIOD", 0.0)
    monkeypatch.setattr(store, "unpack", note_lease)
    ended([uploaded(client, short_zip(length)) for length in (0.8, 0.9)])
    assert leases[0] < leases[1]


def test_a_recording_that_is_given_twice_is_refused(client, recording):
    answer = client.post(PATH, json={"recordings": [recording, recording]})
    assert answer.status_code == 422
    assert answer.json()["errors"] == [
        {
            "where": "body.recordings",
            "problem": f"recording {recording} is given twice; expected each of them once",
        }
    ]


def test_a_cancelled_diagnosis_ends(client, undiagnosed):
    location = client.post(PATH, json={"recordings": [undiagnosed]}).headers["Location"]
    assert client.post(f"{location}/cancel").json()["state"] == "cancelled"
    assert client.post(f"{location}/cancel").status_code == 409
    until(lambda: not multiprocessing.active_children())
    assert client.get(location).json()["state"] == "cancelled"
