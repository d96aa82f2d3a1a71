"""Long work happens outside of the database's one write transaction: meanwhile everybody else can write."""

import pkgutil
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from tests.service.conftest import SESSIONS, drive_zip, sampled, started, uploaded

PATIENCE = 60.0  # [s] after which a call counts as blocked
LOADER = "omnimate.service.store.recordings.read_in_process"
SOLVER = "omnimate.service.routes.umbmark_sessions.make_result"


class Blocked:
    """A function that waits until the test lets it go on."""

    def __init__(self, function):
        self.function, self.entered, self.goes_on = function, Event(), Event()

    def __call__(self, *arguments):
        self.entered.set()
        assert self.goes_on.wait(2.0 * PATIENCE)
        return self.function(*arguments)


@pytest.fixture(scope="module")
def squares(client):
    """The id of a recording of one square each way."""
    return uploaded(client, drive_zip(2.0))


@pytest.fixture
def reading(client, squares):
    """A session's path, a call of it that reads a recording, and the function that takes long."""
    path = started(client, how="recordings", side=2.0)
    return path, lambda: client.post(f"{path}/samples", json={"recording": squares}), LOADER


@pytest.fixture
def solving(client):
    """A session's path, a call that solves it, and the function that takes long."""
    path = started(client)
    sampled(client, path)
    return path, lambda: client.post(f"{path}/solve"), SOLVER


def while_blocked(monkeypatch, call, target, write):
    """Return the answers of a call, and of another one that is made while the first is blocked."""
    blocked = Blocked(pkgutil.resolve_name(target))
    monkeypatch.setattr(target, blocked)
    with ThreadPoolExecutor(2) as threads:
        first = threads.submit(call)
        try:
            assert blocked.entered.wait(PATIENCE)
            second = threads.submit(write).result(PATIENCE)
        finally:
            blocked.goes_on.set()
        return first.result(PATIENCE), second


@pytest.mark.parametrize(("work", "status", "runs"), [("reading", 201, 2), ("solving", 200, 4)])
def test_others_write_while_a_recording_is_read_or_a_session_is_solved(
    client, request, monkeypatch, work, status, runs
):
    path, *long_call = request.getfixturevalue(work)
    first, second = while_blocked(monkeypatch, *long_call, lambda: client.post(SESSIONS, json={}))
    assert (first.status_code, second.status_code) == (status, 201)
    assert len(client.get(path).json()["samples"]) == runs


def test_a_session_that_ends_while_its_recording_is_read_takes_no_run(client, reading, monkeypatch):
    path, *long_call = reading
    first, second = while_blocked(monkeypatch, *long_call, lambda: client.post(f"{path}/abort"))
    assert (first.status_code, second.status_code) == (409, 200)
    assert client.get(path).json()["samples"] == []


def test_a_session_is_not_solved_with_runs_that_it_no_longer_has(client, solving, monkeypatch):
    path, *long_call = solving
    first, second = while_blocked(monkeypatch, *long_call, lambda: client.delete(f"{path}/samples/1"))
    assert (first.status_code, second.status_code) == (409, 200)
    assert "solve it again" in first.json()["detail"]
    assert client.get(path).json()["state"] == "collecting"
    assert client.post(f"{path}/solve").status_code == 200


def test_a_repeated_request_is_answered_without_its_recording(client, squares, monkeypatch):
    path, headers = started(client, how="recordings", side=2.0), {"Idempotency-Key": "once"}
    first = client.post(f"{path}/samples", json={"recording": squares}, headers=headers)
    monkeypatch.delattr(LOADER)
    again = client.post(f"{path}/samples", json={"recording": squares}, headers=headers)
    assert (again.status_code, again.json()) == (201, first.json())
    assert len(client.get(path).json()["samples"]) == 2
