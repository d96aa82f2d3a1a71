"""Long work happens outside of the database's one write transaction: meanwhile everybody else can write."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from omnimate.service.store.recordings import read_in_process
from omnimate.service.umbmark import result

PATIENCE = 60.0  # [s] after which a call counts as blocked
LOADER = "omnimate.service.store.recordings.read_in_process"


class Blocked:
    """A function that waits until the test lets it go on."""

    def __init__(self, function):
        self.function, self.entered, self.goes_on = function, Event(), Event()

    def __call__(self, *arguments):
        self.entered.set()
        assert self.goes_on.wait(2.0 * PATIENCE)
        return self.function(*arguments)


@pytest.fixture
def threads():
    """Calls beside that of the test."""
    with ThreadPoolExecutor(2) as executor:
        yield executor


@pytest.fixture(scope="module")
def squares(client, uploaded):
    """The id of a recording of one square each way."""
    return uploaded(client, 2.0)


def while_blocked(monkeypatch, threads, target, function, call, write):
    """Return the answers of a call, and of another one that is made while the first is blocked."""
    blocked = Blocked(function)
    monkeypatch.setattr(target, blocked)
    first = threads.submit(call)
    try:
        assert blocked.entered.wait(PATIENCE)
        second = threads.submit(write).result(PATIENCE)
    finally:
        blocked.goes_on.set()
    return first.result(PATIENCE), second


def test_others_write_while_a_recording_is_read(client, squares, started, threads, monkeypatch):
    path = started(client, how="recordings", side=2.0)
    first, second = while_blocked(
        monkeypatch, threads, LOADER, read_in_process,
        lambda: client.post(f"{path}/samples", json={"recording": squares}),
        lambda: client.post("/v1/umbmark/sessions", json={}),
    )  # fmt: skip
    assert (first.status_code, second.status_code) == (201, 201)
    assert len(client.get(path).json()["samples"]) == 2


def test_a_session_that_ends_while_its_recording_is_read_takes_no_run(
    client, squares, started, threads, monkeypatch
):
    path = started(client, how="recordings", side=2.0)
    first, second = while_blocked(
        monkeypatch, threads, LOADER, read_in_process,
        lambda: client.post(f"{path}/samples", json={"recording": squares}),
        lambda: client.post(f"{path}/abort"),
    )  # fmt: skip
    assert (first.status_code, second.status_code) == (409, 200)
    assert client.get(path).json()["samples"] == []


def test_others_write_while_a_session_is_solved(client, started, sampled, threads, monkeypatch):
    path = started(client)
    sampled(client, path)
    first, second = while_blocked(
        monkeypatch, threads, f"{result.__name__}.make_result", result.make_result,
        lambda: client.post(f"{path}/solve"),
        lambda: client.post("/v1/umbmark/sessions", json={}),
    )  # fmt: skip
    assert (first.status_code, second.status_code) == (200, 201)


def test_a_session_is_not_solved_with_runs_that_it_no_longer_has(
    client, started, sampled, threads, monkeypatch
):
    path = started(client)
    sampled(client, path)
    first, second = while_blocked(
        monkeypatch, threads, f"{result.__name__}.make_result", result.make_result,
        lambda: client.post(f"{path}/solve"),
        lambda: client.delete(f"{path}/samples/1"),
    )  # fmt: skip
    assert (first.status_code, second.status_code) == (409, 200)
    assert "solve it again" in first.json()["detail"]
    assert client.get(path).json()["state"] == "collecting"
    assert client.post(f"{path}/solve").status_code == 200


def test_a_repeated_request_is_answered_without_its_recording(client, squares, started, monkeypatch):
    path, headers = started(client, how="recordings", side=2.0), {"Idempotency-Key": "once"}
    first = client.post(f"{path}/samples", json={"recording": squares}, headers=headers)
    monkeypatch.delattr(LOADER)
    again = client.post(f"{path}/samples", json={"recording": squares}, headers=headers)
    assert (again.status_code, again.json()) == (201, first.json())
    assert len(client.get(path).json()["samples"]) == 2
