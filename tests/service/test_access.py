"""Who may do what: keys, roles, other sites, and listening to the network."""

import pytest

from cli.serve import OpenDoorError, _listen
from service.access import add_key, revoke_key
from service.settings import Settings


@pytest.fixture
def locked(tmp_path, serving):
    """A service with a key of each role."""
    with serving(f"sqlite:///{tmp_path}/service.db") as client:
        with client.parts.database.writing() as db:
            client.keys = {role: add_key(db, role, role) for role in ("read", "operate")}
        yield client


def bearer(key):
    return {"Authorization": f"Bearer {key}"}


def test_on_loopback_without_keys_everybody_may_operate(client):
    assert client.post("/v1/umbmark/sessions", json={}).status_code == 201


def test_with_keys_nothing_is_told_without_one(locked):
    answer = locked.get("/v1/vehicles")
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"] == "Bearer"
    assert "omnimate key add" in answer.json()["detail"]
    assert locked.get("/healthz").status_code == 200


@pytest.mark.parametrize("key", ["", "omk_", "omk_00000000_x", "x", "omk_é"])
def test_a_wrong_key_is_none(locked, key):
    assert locked.get("/v1/vehicles", headers={"Authorization": f"Bearer {key}".encode()}).status_code == 401


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


def test_a_revoked_key_opens_nothing_and_does_not_open_the_house(locked):
    key = locked.keys["operate"]
    with locked.parts.database.writing() as db:
        for one in locked.keys.values():
            revoke_key(db, one.split("_")[1])
    answer = locked.get("/v1/vehicles", headers=bearer(key))
    assert (answer.status_code, "revoked" in answer.json()["detail"]) == (401, True)
    assert locked.get("/v1/vehicles").status_code == 401


def test_secrets_are_not_kept(locked):
    with locked.parts.database.engine.connect() as connection:
        kept = str(connection.exec_driver_sql("select * from keys").all())
    assert all(key.split("_", 2)[2] not in kept for key in locked.keys.values())


def test_other_sites_and_other_names_are_refused(client):
    assert client.get("/v1/vehicles", headers={"Origin": "https://evil.example"}).status_code == 403
    assert client.get("/v1/vehicles", headers={"Host": "evil.example"}).status_code == 403
    own = client.get("/v1/vehicles", headers={"Origin": "http://127.0.0.1"})
    assert own.status_code == 200
    assert "access-control-allow-origin" not in own.headers


def test_it_does_not_listen_to_the_network_without_a_key(tmp_path):
    with pytest.raises(OpenDoorError, match="omnimate key add"):
        _listen(Settings(database=f"sqlite:///{tmp_path}/service.db", host="0.0.0.0"))


def test_too_many_calls_are_told_to_wait(tmp_path, serving):
    with serving(f"sqlite:///{tmp_path}/service.db") as client:
        object.__setattr__(client.parts.settings, "rate", 1.0)
        answers = [client.get("/healthz").status_code for _ in range(10)]
        assert answers.count(200) >= 1
        assert answers[-1] == 429


def test_every_error_is_a_problem_detail(client):
    for answer in (
        client.get("/v1/nothing"),
        client.patch("/v1/vehicles"),
        client.get("/v1/vehicles/nobody"),
        client.post("/v1/umbmark/sessions", content="{", headers={"Content-Type": "application/json"}),
        client.get("/v1/umbmark/sessions?limit=0"),
    ):
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.json()["status"] == answer.status_code
        assert len(answer.json()["detail"]) > 20
    assert client.patch("/v1/vehicles").headers["allow"] == "GET, POST"
