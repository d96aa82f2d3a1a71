"""The limits of requests: sizes, other sites, other names of the host, and the rate of one caller."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.service import limits
from omnimate.service.limits import BURST_TIME, REMEMBERED_CALLERS, STOPS, Limits
from omnimate.service.settings import Settings
from tests.service.conftest import serving, started


@pytest.fixture(scope="module")
def now():
    """A clock of the limits alone, which a test sets."""
    time = {"now": 100.0}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(limits, "time", SimpleNamespace(monotonic=lambda: time["now"]))
        yield time


def accepted(limited, now, pauses):
    """Return the times of the calls that were accepted, after each pause one call."""
    times = []
    for pause in pauses:
        now["now"] += pause
        if limited._take_token("caller"):
            times.append(now["now"])
    return times


@given(rate=st.floats(1.0, 100.0), pauses=st.lists(st.floats(0.0, 2.0), max_size=100))
def test_in_no_span_of_time_more_calls_are_accepted_than_the_burst_and_the_rate_allow(now, rate, pauses):
    times = accepted(Limits(None, Settings(rate=rate)), now, pauses)
    for first, start in enumerate(times):
        for last, end in enumerate(times[first:], start=first):
            assert last - first + 1 <= rate * (BURST_TIME + end - start) + 1e-6


@given(rate=st.floats(1.0, 100.0), slower=st.floats(1.001, 3.0))
def test_a_caller_that_keeps_to_the_rate_is_never_refused(now, rate, slower):
    pauses = [slower / rate] * 50
    assert len(accepted(Limits(None, Settings(rate=rate)), now, pauses)) == 50


def test_one_caller_does_not_use_the_tokens_of_another(now):
    limited = Limits(None, Settings(rate=1.0))
    while limited._take_token("busy"):
        pass
    assert limited._take_token("quiet")


def test_the_memory_of_callers_is_bounded(now):
    limited = Limits(None, Settings())
    for number in range(REMEMBERED_CALLERS + 10):
        limited._take_token(str(number))
    assert len(limited._buckets) == REMEMBERED_CALLERS


def test_too_many_calls_are_refused_with_the_time_to_wait_and_no_stop_is(tmp_path, now):
    """Whoever shares the address, behind a proxy too, may have used them up, also without a key."""
    with serving(f"sqlite:///{tmp_path}/service.db") as client:
        session = started(client)
        object.__setattr__(client.components.settings, "rate", 1.0)
        while (answer := client.get("/healthz")).status_code != 429:
            assert answer.status_code == 200
        assert answer.headers["Retry-After"] == "1"
        assert client.post("/v1/robot/stop").status_code == 200
        assert client.post(f"{session}/abort").json()["state"] == "aborted"
        assert client.get(session).status_code == 429


def test_every_call_that_stops_a_robot_is_known_to_the_limits(client):
    calls = client.get("/openapi.json").json()["paths"]
    stops = {path for path in calls if path.rpartition("/")[2] in {"stop", "abort"}}
    assert stops == {path for path in calls if STOPS.fullmatch(path)}
    assert stops == {"/v1/robot/stop", "/v1/umbmark/sessions/{session_id}/abort"}


def test_the_same_site_is_accepted_and_no_other_is_invited(client):
    same_origin = client.get("/v1/vehicles", headers={"Origin": "http://127.0.0.1"})
    assert same_origin.status_code == 200
    assert "access-control-allow-origin" not in same_origin.headers


@pytest.mark.parametrize("host", ["localhost", "localhost:8080", "127.0.0.1:80", "[::1]", "[::1]:8080"])
def test_every_name_of_loopback_is_accepted(client, host):
    assert client.get("/healthz", headers={"Host": host}).status_code == 200


def test_two_gigabytes_are_refused_before_they_are_sent(client):
    headers = {"Content-Type": "application/zip", "Content-Length": "2000000000"}
    answer = client.post("/v1/recordings", content=b"x", headers=headers)
    assert answer.status_code == 413
    assert "at most 200000000" in answer.json()["detail"]


def test_a_body_that_does_not_say_how_long_it_is_ends_at_the_limit(client):
    answer = client.post("/v1/umbmark/sessions", content=(bytes(100_000) for _ in range(20)),
                         headers={"Content-Type": "application/json"})  # fmt: skip
    assert answer.status_code == 413


@pytest.mark.parametrize("path", ["/", "/v1/vehicles", "/v1/nothing"])
def test_every_answer_forbids_what_the_page_does_not_need(client, path):
    headers = client.get(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert "default-src 'self'" in headers["content-security-policy"]
