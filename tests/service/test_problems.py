"""Problem details, RFC 9457: the answers to refused requests, word for word, and to errors of the service."""

import errno
import json
import re
import time
from http import HTTPStatus

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient
from sqlalchemy.exc import OperationalError

from omnimate.service.errors import ServiceError
from omnimate.service.problems import DISK_FULL, MEDIA, documented, install
from omnimate.service.store.tables import SessionRow
from omnimate.vehicle.errors import OmnimateError
from tests.samples import broken
from tests.service.conftest import sampled, started


@pytest.fixture(scope="module")
def sessions(client):
    """The ids of sessions in several states, by the words for them."""
    paths = {
        state: started(client) for state in ("collecting", "aborted", "expired", "overtaken", "accepted")
    }
    paths["recordings"] = started(client, how="recordings")
    client.post(f"{paths['aborted']}/abort")
    ids = {state: path.rpartition("/")[2] for state, path in paths.items()}
    with client.components.database.writing() as db:
        db.get(SessionRow, ids["expired"]).expires = time.time() - 1.0
    for state in ("overtaken", "accepted"):
        sampled(client, paths[state])
        client.post(f"{paths[state]}/solve")
    client.post(f"{paths['accepted']}/accept", headers={"If-Match": "*"})
    solved = started(client)
    sampled(client, solved)
    revision = client.post(f"{solved}/solve").json()["revision"]
    return ids | {"solved": solved.rpartition("/")[2], "revision": revision}


def filled(text, sessions):
    """Return a text with the ids of the sessions that it names."""
    return re.sub(r"\{(\w+)\}", lambda match: sessions[match[1]], text)


@pytest.mark.parametrize(
    "case",
    broken("service/problems.toml"),
    ids=lambda case: f"{case['method']} {case['path']} {case['status']}",
)
def test_a_refused_request_is_answered_with_its_problem_detail(client, sessions, case):
    body = json.dumps(case["json"]) if "json" in case else case.get("body")
    headers = ({"Content-Type": "application/json"} if "json" in case else {}) | case.get("headers", {})
    answer = client.request(case["method"], filled(case["path"], sessions), content=body, headers=headers)
    assert answer.headers["content-type"] == MEDIA
    problem = answer.json()
    assert (answer.status_code, problem["status"], problem["title"], problem["detail"]) == (
        case["status"],
        case["status"],
        case["title"],
        filled(case["detail"], sessions),
    )
    assert problem.get("possible") == case.get("possible")
    errors = problem.get("errors") or []
    assert [wrong["where"] for wrong in errors] == case.get("where", [])
    assert (
        not errors
        or "; ".join(f"{wrong['where']}: {wrong['problem']}" for wrong in errors) == problem["detail"]
    )


JSON = {"Content-Type": "application/json"}


@pytest.mark.parametrize("body", [b"\xff", b"\x1f\x8b\x08", b"[" * 100_000, b"9" * 10_000])
def test_a_body_that_is_no_json_is_refused_with_what_is_expected(client, body):
    answer = client.post("/v1/umbmark/sessions", content=body, headers=JSON)
    assert answer.status_code == 422
    assert answer.json()["errors"] == [
        {"where": "body", "problem": "no JSON; expected JSON (RFC 8259) in UTF-8"}
    ]


@pytest.mark.parametrize(
    ("encoding", "status"), [("gzip", 415), ("br", 415), ("gzip, br", 415), ("identity", 201)]
)
def test_a_body_is_taken_as_it_is_and_no_encoding_of_it(client, encoding, status):
    answer = client.post("/v1/umbmark/sessions", content=b"{}", headers=JSON | {"Content-Encoding": encoding})
    assert answer.status_code == status
    assert status == 201 or answer.json()["detail"].startswith(
        f"content encoding '{encoding}'; send the body"
    )


def test_a_method_that_a_path_does_not_have_is_answered_with_those_that_it_has(client):
    assert client.patch("/v1/vehicles").headers["allow"] == "GET, HEAD, POST"


@pytest.mark.parametrize(
    "path", ["/", "/healthz", "/v1/vehicles", "/v1/robot/stream", "/v1/nothing", "/page/dom.js"]
)
def test_head_is_answered_by_the_headers_of_get(client, path):
    answer = client.head(path)
    assert (answer.status_code, answer.content) == (404 if path.endswith("nothing") else 200, b"")
    assert int(answer.headers.get("Content-Length", "1")) > 0


def answer_to(error):
    """Return the answer of an application whose only call raises an error."""
    app = FastAPI()
    install(app)

    @app.get("/")
    def fail() -> None:
        raise error

    with TestClient(app, raise_server_exceptions=False) as client:
        return client.get("/")


def every_error(kind=ServiceError):
    yield kind
    for derived in kind.__subclasses__():
        yield from every_error(derived)


@pytest.mark.parametrize("kind", list(every_error()), ids=lambda kind: kind.__name__)
def test_every_error_of_the_service_has_a_status_of_http_and_a_title(kind):
    assert 400 <= HTTPStatus(kind.status) < 600
    assert kind.title


class FullDatabaseError(Exception):
    """PostgreSQL's error of a full disk."""

    sqlstate = "53100"


@pytest.mark.parametrize(
    ("error", "status", "detail"),
    [
        (OmnimateError("the wheelbase is negative"), 422, "the wheelbase is negative"),
        (OperationalError("select", {}, OSError()), 503, "the database did not answer; try again"),
        (OperationalError("insert", {}, FullDatabaseError()), 503, DISK_FULL),
        (OSError(errno.ENOSPC, "secret"), 503, DISK_FULL),
        (OSError(errno.EIO, "secret"), 500, "an error in the service itself; its log says more"),
        (KeyError("secret"), 500, "an error in the service itself; its log says more"),
    ],
)
def test_errors_of_others_are_problem_details_that_tell_no_secret(error, status, detail):
    answer = answer_to(error)
    assert (answer.status_code, answer.json()["detail"]) == (status, detail)


@pytest.mark.parametrize("status", [404, 409, 428])
def test_a_documented_problem_refers_to_the_schema_of_problem_details(status):
    described = documented(status)[status]
    assert described["description"] == HTTPStatus(status).phrase
    assert described["content"][MEDIA]["schema"] == {"$ref": "#/components/schemas/Problem"}
