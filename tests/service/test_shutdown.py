"""SIGTERM: the robot stops, streams end, a request in work is answered, and a job is queued again."""

import json
import signal
import socket

import httpx2
import pytest

from omnimate.service.store.database import Database
from omnimate.service.store.tables import JobRow, SessionRow
from tests.service.conftest import LONG_DRIVE, drive_zip, until, uploaded

service_process = pytest.importorskip("studies.speed.service_process")


def half_sent(url, body):
    """Return a connection over which a request was sent up to the middle of its body.

    The service has it in work: it answers `Expect: 100-continue` where it begins to read the body
    (RFC 9110, 10.1.1). The connection of a request that it has not begun to read is reset by SIGTERM.
    """
    host, port = url.removeprefix("http://").split(":")
    connection = socket.create_connection((host, int(port)), timeout=60.0)
    head = (
        f"POST /v1/umbmark/sessions HTTP/1.1\r\nHost: {host}:{port}\r\nContent-Type: application/json\r\n"
        f"Content-Length: {len(body)}\r\nExpect: 100-continue\r\n\r\n"
    )
    connection.sendall(head.encode() + body[:5])
    assert connection.recv(65536).startswith(b"HTTP/1.1 100 ")
    return connection


def test_sigterm_ends_a_service_in_good_order(tmp_path):
    url = f"sqlite:///{tmp_path}/service.db"
    with (
        service_process.serving(tmp_path, url) as service,
        httpx2.Client(base_url=service.url, timeout=60.0) as client,
    ):
        recording = uploaded(client, drive_zip(4.0))
        session = client.post("/v1/umbmark/sessions", json=LONG_DRIVE).json()["id"]
        until(lambda: any(client.get("/v1/robot").json()["state"]["wheels"]))
        job = client.post("/v1/diagnoses", json={"recordings": [recording]}).json()["id"]
        until(lambda: client.get(f"/v1/diagnoses/{job}").json()["state"] == "running")
        body = json.dumps({"side": 4.0, "runs": 2}).encode()
        with client.stream("GET", "/v1/robot/stream") as stream, half_sent(service.url, body) as connection:
            service.process.send_signal(signal.SIGTERM)
            for _event in stream.iter_raw():
                pass  # the stream ends, though the service still waits for the request
            connection.sendall(body[5:])
            answer = connection.recv(65536)
        assert answer.startswith(b"HTTP/1.1 201 ")
        assert service.process.wait(service_process.PATIENCE) == -signal.SIGTERM
        service.process.stdout.close()
    database = Database(url)
    with database.reading() as db:
        driven, waiting = db.get(SessionRow, session), db.get(JobRow, job)
        assert (driven.state, driven.detail) == ("interrupted", "interrupted: the service was stopped")
        assert (waiting.state, waiting.attempts) == ("queued", 0)
    database.close()
