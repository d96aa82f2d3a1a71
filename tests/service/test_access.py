"""Who may do what: API keys, their roles, and a service without a key."""

import asyncio
from types import SimpleNamespace

import pytest

from omnimate.cli.errors import CallError
from omnimate.cli.serve import _listen
from omnimate.service import access
from omnimate.service.access import Caller, add_key, revoke_key
from omnimate.service.calls import Call
from omnimate.service.routes import robot
from omnimate.service.settings import Settings
from tests.service.conftest import away, sampled, serving, started


@pytest.fixture(scope="module")
def keyed(tmp_path_factory):
    """A service that holds keys once a test has added some."""
    with serving(f"sqlite:///{tmp_path_factory.mktemp('keyed')}/service.db") as client:
        yield client


@pytest.fixture
def locked(keyed):
    """The service with a new key of each role."""
    with keyed.components.database.writing() as db:
        keyed.keys = {role: add_key(db, role, role) for role in ("read", "operate")}
    return keyed


def bearer(key):
    return {"Authorization": f"Bearer {key}"}


def test_with_keys_nothing_is_answered_without_one(locked):
    answer = locked.get("/v1/vehicles")
    assert answer.status_code == 401
    assert locked.get("/v1/vehicles", headers={"Authorization": "Bearer omk_é".encode()}).status_code == 401
    assert answer.headers["www-authenticate"] == "Bearer"
    assert "omnimate key add" in answer.json()["detail"]
    assert locked.get("/healthz").status_code == 200


def test_a_version_names_its_key_and_the_session_whose_result_it_is(database_url):
    with serving(database_url) as client:
        with client.components.database.writing() as db:
            client.headers |= bearer(add_key(db, "laptop", "operate"))
        path = started(client)
        sampled(client, path)
        client.post(f"{path}/solve")
        client.post(f"{path}/accept", headers={"If-Match": "*"})
        text = client.get("/v1/vehicles/omnimate").json()["toml"]
        headers = {"Content-Type": "application/toml", "If-Match": "*"}
        client.put("/v1/vehicles/omnimate", content=text, headers=headers)
        client.post("/v1/vehicles", content=text.replace('"omnimate"', '"another"', 1), headers=headers)
        versions = client.get("/v1/vehicles/omnimate/versions").json()
        another = client.get("/v1/vehicles/another").json()
    session = path.rpartition("/")[2]
    assert [(version["made_by"], version["session"]) for version in (another, *versions)] == [
        ("laptop", None),
        ("laptop", None),
        ("laptop", session),
        (None, None),
    ]


def test_a_key_to_read_reads_and_stops_and_changes_nothing(locked):
    mine = bearer(locked.keys["read"])
    assert locked.get("/v1/vehicles", headers=mine).status_code == 200
    assert locked.post("/v1/robot/stop", headers=mine).status_code == 200
    answer = locked.post("/v1/umbmark/sessions", json={}, headers=mine)
    assert answer.status_code == 403
    assert "operate" in answer.json()["detail"]
    assert (
        locked.post("/v1/umbmark/sessions", json={}, headers=bearer(locked.keys["operate"])).status_code
        == 201
    )


def test_streams_end_when_their_key_is_revoked(locked, monkeypatch):
    """A stream that is read counts as the presence of a client, so that the robot of a session drives on."""
    monkeypatch.setattr(robot, "KEY_PERIOD", 0.0)
    key = locked.keys["read"]
    call = Call(locked.components, Caller("another", "read"), None, "", f"Bearer {key}")

    async def endless():
        while True:
            yield b""
            await asyncio.sleep(0)

    async def read_to_the_end(events):
        return [event async for event in events]

    async def read_until_revoked():
        events = robot._while_allowed(call, endless())
        for _ in range(100):
            await anext(events)
        with locked.components.database.writing() as db:
            revoke_key(db, key.split("_")[1])
        await read_to_the_end(events)

    asyncio.run(read_until_revoked())
    assert list(robot._lines(call, 10)) == []


def test_a_known_key_stops_the_robot_while_the_database_is_away(locked, monkeypatch):
    known, unknown = bearer(locked.keys["read"]), bearer(locked.keys["operate"])
    assert locked.get("/v1/vehicles", headers=known).status_code == 200
    monkeypatch.setattr(access, "caller_of", away)
    later = access.time.monotonic() + 3600.0
    monkeypatch.setattr(access, "time", SimpleNamespace(monotonic=lambda: later))
    assert locked.get("/v1/robot", headers=known).status_code == 503
    assert locked.post("/v1/robot/stop", headers=known).status_code == 200
    assert locked.post("/v1/robot/stop", headers=unknown).status_code == 503


def test_secrets_are_not_kept(locked):
    with locked.components.database.engine.connect() as connection:
        kept = str(connection.exec_driver_sql("select * from keys").all())
    assert all(key.split("_", 2)[2] not in kept for key in locked.keys.values())


def test_a_service_that_others_can_reach_needs_a_key(tmp_path):
    with pytest.raises(CallError, match="omnimate key add"):
        _listen(Settings(database=f"sqlite:///{tmp_path}/service.db", host="0.0.0.0"), as_json=False)
