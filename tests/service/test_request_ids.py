"""Every request has an id: taken over from the client, in the answer, in problem details and in the log."""

import json
import logging
import re
import sys

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient

from omnimate.service.problems import install
from omnimate.service.request_log import JsonLines, RequestIds

MADE = re.compile(r"[0-9a-f]{16}")


def failing(_name):
    raise RuntimeError("boom")


@pytest.fixture
def answers():
    """A client of an application that greets, and fails with an error of its own."""
    app = FastAPI()
    install(app)
    app.add_middleware(RequestIds)
    app.get("/hello")(lambda: {"greeting": "hello"})
    app.get("/failing/{_name}")(failing)
    with TestClient(app, raise_server_exceptions=False) as client:
        yield client


def test_a_harmless_id_is_taken_over(answers):
    assert (
        answers.get("/hello", headers={"X-Request-ID": "fleet-7.a_B"}).headers["x-request-id"]
        == "fleet-7.a_B"
    )


@pytest.mark.parametrize("sent", ["", "two words", 'quote"', "x" * 129, "a\tb", "\u00e9"])
def test_any_other_id_is_replaced_by_a_new_one(answers, sent):
    headers = {"X-Request-ID": sent.encode("latin-1")}
    assert MADE.fullmatch(answers.get("/hello", headers=headers).headers["x-request-id"])


def test_two_requests_have_different_ids(answers):
    first, second = (answers.get("/hello").headers["x-request-id"] for _ in range(2))
    assert first != second


@pytest.mark.parametrize(("path", "status"), [("/none", 404), ("/failing/x", 500)])
def test_a_problem_detail_names_the_id(answers, path, status):
    answer = answers.get(path, headers={"X-Request-ID": "seen"})
    assert (answer.status_code, answer.json()["request_id"]) == (status, "seen")
    assert answer.headers.get_list("x-request-id") == ["seen"]


def test_an_answer_of_the_limits_has_an_id_too(client):
    answer = client.get("/healthz", headers={"Host": "elsewhere"})
    assert answer.status_code == 403
    assert answer.json()["request_id"] == answer.headers["x-request-id"]


def test_every_line_of_the_log_about_a_request_is_one_json_object_with_its_id(answers, caplog, monkeypatch):
    monkeypatch.setattr(caplog.handler, "formatter", JsonLines())
    with caplog.at_level(logging.INFO, "omnimate.service"):
        answers.get("/failing/a%0Ab", headers={"X-Request-ID": "seen"})
    written = [json.loads(line) for line in caplog.text.splitlines()]
    assert {line["request_id"] for line in written} == {"seen"}
    assert {line["level"] for line in written} == {"info", "error"}
    request, error = sorted(written, key=lambda line: line["level"], reverse=True)
    assert re.fullmatch(r"GET /failing/a\nb: 500 after [\d.]+ s", request["message"])
    assert "RuntimeError: boom" in error["exception"]


def test_a_line_without_a_request_has_no_id():
    try:
        failing("x")
    except RuntimeError:
        record = logging.LogRecord("omnimate.x", logging.ERROR, "", 0, "%s failed", ("it",), sys.exc_info())
    line = json.loads(JsonLines().format(record))
    assert line.keys() == {"time", "level", "logger", "message", "exception"}
    assert (line["level"], line["logger"], line["message"]) == ("error", "omnimate.x", "it failed")
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+00:00", line["time"])
