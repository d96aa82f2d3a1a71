"""How calls are sent, repeated and refused, against a server that answers from a list."""

import json

import pytest

from omnimate.client import Client, ProblemError, UnreachableError, UrlError
from omnimate.client.transport import Event
from tests.client.answering import LOST, Answering, answering

PROBLEM = "application/problem+json"
BUSY = {"status": 429, "title": "Too many", "detail": "50 diagnoses wait"}
HEALTHY = (200, {"Content-Type": "application/json"}, '{"status": "ok"}')
WEBHOOK = (201, {"Content-Type": "application/json"}, '{"id": "w1"}')


@pytest.fixture
def server():
    with answering() as opened:
        yield opened


@pytest.fixture
def pauses(monkeypatch):
    """The pauses between repetitions [s], which pass at once."""
    taken = []
    monkeypatch.setattr("omnimate.client.transport.time.sleep", taken.append)
    return taken


def refused(status, after=None):
    headers = {"Content-Type": PROBLEM} | ({} if after is None else {"Retry-After": after})
    return status, headers, json.dumps(BUSY | {"status": status})


@pytest.mark.parametrize("status", [429, 503])
def test_a_call_that_changes_nothing_is_repeated_after_the_time_that_the_service_names(
    server, pauses, status
):
    server.answers = [refused(status, "7"), refused(status), HEALTHY]
    assert Client(server.url).health.get_health() == {"status": "ok"}
    assert pauses == [7.0, 1.0]


def test_a_change_is_repeated_with_the_same_key_and_another_one_gets_another_key(server, pauses):
    server.answers = [refused(503, "2"), LOST, WEBHOOK, WEBHOOK]
    client = Client(server.url)
    client.fleets.create_webhook("hall", url="https://receiver.example")
    client.fleets.create_webhook("hall", url="https://receiver.example")
    first, second, third, other = (headers["Idempotency-Key"] for _, _, headers, _ in server.requests)
    assert first == second == third != other
    assert pauses == [2.0, 1.0]


def test_a_key_of_the_caller_is_sent_as_it_is(server):
    server.answers = [WEBHOOK]
    Client(server.url).fleets.create_webhook(
        "hall", idempotency_key="night 1", url="https://receiver.example"
    )
    assert server.requests[0][2]["Idempotency-Key"] == "night 1"


def test_a_change_without_a_key_is_sent_once(server, pauses):
    server.answers = [refused(503, "2")]
    with pytest.raises(ProblemError):
        Client(server.url).robot.stop_robot()
    assert (len(server.requests), pauses) == (1, [])


@pytest.mark.parametrize(("after", "patience"), [("61", 60.0), ("1", 0.0)])
def test_a_call_is_not_repeated_beyond_the_patience(server, pauses, after, patience):
    server.answers = [refused(429, after)]
    with pytest.raises(ProblemError) as caught:
        Client(server.url, patience=patience).health.get_health()
    assert (caught.value.status, caught.value.retry_after, pauses) == (429, float(after), [])


def test_other_problems_are_not_repeated_and_hold_all_parts_of_the_document(server, pauses):
    problem = {
        "type": "https://example.org/full",
        "title": "Not as expected",
        "status": 422,
        "detail": "body.side: 0",
        "possible": ["solve"],
        "errors": [{"where": "body.side", "problem": "0"}],
        "request_id": "r1",
    }
    server.answers = [(422, {"Content-Type": PROBLEM}, json.dumps(problem))]
    with pytest.raises(ProblemError, match=r"^422 Not as expected: body\.side: 0$") as caught:
        Client(server.url).health.get_health()
    error = caught.value
    assert (error.type, error.title, error.detail) == (problem["type"], problem["title"], problem["detail"])
    assert (error.possible, error.errors, error.request_id) == (("solve",), (("body.side", "0"),), "r1")
    assert pauses == []


def test_an_error_of_a_proxy_is_a_problem_of_its_status_with_its_text(server):
    server.answers = [(502, {"Content-Type": "text/html"}, "<h1>Bad Gateway</h1>")]
    with pytest.raises(ProblemError) as caught:
        Client(server.url).health.get_health()
    assert (caught.value.status, caught.value.detail) == (502, "<h1>Bad Gateway</h1>")


def test_an_answer_that_is_lost_again_and_again_ends_with_the_patience(server, pauses):
    server.answers = [LOST]
    with pytest.raises(UnreachableError, match="closed connection without response"):
        Client(server.url, patience=0.5).health.get_health()
    assert pauses == []


def test_an_address_at_which_nothing_answers_is_named_at_once(pauses):
    with Answering() as closed:
        url = closed.url
    with pytest.raises(UnreachableError, match=f"{url}/healthz: .*refused.*is the service running"):
        Client(url).health.get_health()
    assert pauses == []


@pytest.mark.parametrize("url", ["file:///etc", "127.0.0.1:8080", ""])
def test_an_address_that_is_no_url_of_the_web_is_refused(url):
    with pytest.raises(UrlError, match="expected one such as"):
        Client(url)


def test_names_and_queries_are_quoted_and_what_is_not_given_is_left_out(server):
    empty = (200, {"Content-Type": "application/json"}, '{"items": [], "next": null}')
    server.answers = [HEALTHY, empty, HEALTHY]
    client = Client(f"{server.url}/")
    client.vehicles.get_vehicle("a/b ?ü")
    list(client.umbmark.list_sessions())
    client.learned.get_learned_of_recording("r1", uncalibrated=True)
    assert [path for _, path, _, _ in server.requests] == [
        "/v1/vehicles/a%2Fb%20%3F%C3%BC",
        "/v1/umbmark/sessions?limit=50",
        "/v1/recordings/r1/learned?uncalibrated=true",
    ]


@pytest.mark.parametrize(
    ("given", "sent"), [(3, '"3"'), ("5f1c", '"5f1c"'), ('"5f1c"', '"5f1c"'), ("*", "*")]
)
def test_a_version_is_sent_as_an_etag(server, given, sent):
    server.answers = [HEALTHY]
    Client(server.url).vehicles.change_vehicle("tug", "# toml", if_match=given)
    assert server.requests[0][2]["If-Match"] == sent


def test_the_api_key_is_not_sent_to_where_the_service_redirects(server):
    server.answers = [(302, {"Location": f"{server.url}/elsewhere"}, ""), HEALTHY]
    Client(server.url, "secret").health.get_health()
    first, second = (headers for _, _, headers, _ in server.requests)
    assert first["Authorization"] == "Bearer secret"
    assert "Authorization" not in second


def test_a_page_is_requested_when_it_is_needed(server):
    pages = [{"items": ["a", "b"], "next": "b"}, {"items": ["c"], "next": None}]
    server.answers = [(200, {"Content-Type": "application/json"}, json.dumps(page)) for page in pages]
    days = Client(server.url).fleets.list_nights("hall", page_size=2)
    assert (next(days), next(days), len(server.requests)) == ("a", "b", 1)
    assert list(days) == ["c"]
    assert server.requests[1][1] == "/v1/fleets/hall/nights?limit=2&after=b"


def test_a_stream_yields_its_events_and_ignores_comments(server):
    text = 'event: state\ndata: {"time": 1}\n\n: ping\n\nevent: job\ndata: {"id":\ndata: "j1"}\n\n'
    server.answers = [(200, {"Content-Type": "text/event-stream"}, text)]
    assert list(Client(server.url).robot.stream_robot()) == [
        Event("state", {"time": 1}),
        Event("job", {"id": "j1"}),
    ]
