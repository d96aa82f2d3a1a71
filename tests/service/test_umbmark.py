"""UMBmark over REST, by hand: what is started, sampled, solved and accepted, and what is refused."""

import json

import pytest

from tests.service.conftest import SESSIONS, TRUE, manual_runs, sampled, started


def test_a_session_by_hand_finds_the_true_sizes_and_makes_a_new_version(service):
    path = started(service)
    before = service.get("/v1/vehicles/omnimate")
    sampled(service, path)
    result = service.post(f"{path}/solve")
    assert result.status_code == 200
    sizes = result.json()["trucks"]["a"]["calibrated"]
    assert sizes["wheelbase"] == pytest.approx(TRUE.wheelbase, rel=1e-6)
    ratio = TRUE.wheel_diameter_right / TRUE.wheel_diameter_left
    assert sizes["wheel_diameter_right"] / sizes["wheel_diameter_left"] == pytest.approx(ratio, rel=1e-6)
    accepted = service.post(f"{path}/accept", headers={"If-Match": result.headers["ETag"]})
    assert accepted.json()["state"] == "accepted"
    after = service.get("/v1/vehicles/omnimate")
    assert after.json()["version"] == before.json()["version"] + 1
    former = service.get(f"/v1/vehicles/omnimate/versions/{before.json()['version']}")
    assert former.json()["toml"] == before.json()["toml"]


def test_a_new_session_was_changed_when_it_was_created(service):
    sessions = [service.get(started(service)).json() for _ in range(5)]
    assert [session["changed"] - session["created"] for session in sessions] == [0.0] * 5


def test_all_methods_stand_side_by_side_with_intervals_that_hold_the_truth(client):
    path = started(client, runs=5)
    sampled(client, path, 5, scatter=0.005)
    methods = client.post(f"{path}/solve").json()["trucks"]["a"]["methods"]
    assert {method["method"] for method in methods} >= {"printed", "exact", "weighted", "heading"}
    for method in methods:
        assert method["e_b"]["low"] < method["e_b"]["value"] < method["e_b"]["high"]


def test_a_run_that_is_left_out_takes_the_result_with_it(client):
    path = started(client)
    sampled(client, path)
    first = client.post(f"{path}/solve").json()
    assert client.delete(f"{path}/samples/2").status_code == 200
    assert client.get(path).json()["state"] == "collecting"
    assert client.get(f"{path}/result").status_code == 409
    assert client.post(f"{path}/solve").json()["revision"] != first["revision"]
    assert client.delete(f"{path}/samples/2").status_code == 404


@pytest.mark.parametrize(
    ("body", "where"),
    [
        ('{"side": NaN}', "body.side"),
        ('{"side": 1e308}', "body.side"),
        ('{"runs": 0}', "body.runs"),
        ('{"side": true}', "body.side"),
        ('{"side": "4"}', "body.side"),
        ('{"runs": "5"}', "body.runs"),
        ('{"speed": false}', "body.speed"),
        ("[]", "body"),
    ],
)
def test_a_start_that_no_robot_can_drive_is_refused_with_the_field(client, body, where):
    answer = client.post(SESSIONS, content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["where"] == where


@pytest.mark.parametrize("x", ["NaN", "Infinity", "1e308", '"far"'])
def test_a_pose_that_is_nowhere_is_refused_and_nothing_is_kept(client, x):
    path = started(client)
    body = json.dumps(next(manual_runs())).replace('"after": {"x": ', f'"after": {{"x": {x}, "z": ')
    answer = client.post(f"{path}/samples", content=body, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422
    assert client.get(path).json()["samples"] == []


def test_the_plot_is_a_picture_of_each_kind(client):
    path = started(client)
    sampled(client, path)
    client.post(f"{path}/solve")
    assert client.get(f"{path}/plot.png").content.startswith(b"\x89PNG")
    assert b"<svg" in client.get(f"{path}/plot.svg").content[:500]


def test_lists_are_read_page_by_page_newest_first(service):
    made = [started(service).rpartition("/")[2] for _ in range(5)]
    seen, after = [], None
    while len(seen) < 5:
        query = {"limit": 2} | ({"after": after} if after else {})
        page = service.get(SESSIONS, params=query).json()
        seen += [session["id"] for session in page["items"]]
        after = page["next"]
    assert seen[:5] == made[::-1]
    assert service.get(SESSIONS, params={"after": "none"}).status_code == 422


def test_a_vehicle_is_changed_only_by_who_saw_its_newest_version(service):
    text = service.get("/v1/vehicles/omnimate").json()["toml"]
    other = text.replace('"omnimate"', '"hall-robot"')
    made = service.post("/v1/vehicles", content=other, headers={"Content-Type": "application/toml"})
    assert (made.status_code, made.headers["ETag"]) == (201, '"1"')
    again = service.post("/v1/vehicles", content=other, headers={"Content-Type": "application/toml"})
    assert again.status_code == 409
    path, wider = "/v1/vehicles/hall-robot", other.replace("wheelbase = 0.34", "wheelbase = 0.35", 1)
    toml = {"Content-Type": "application/toml"}
    assert service.put(path, content=wider, headers=toml | {"If-Match": '"7"'}).status_code == 412
    assert service.put(path, content=wider, headers=toml | {"If-Match": '"1"'}).json()["version"] == 2
    assert [version["version"] for version in service.get(f"{path}/versions").json()] == [2, 1]
    assert "wheel_separation_multiplier: 1.0294" in service.get(f"{path}/exports/ros2").text
    assert len(service.get(f"{path}/exports/vda5050").json()["wheelDefinitions"]) == 4


@pytest.mark.parametrize("name", ["x" * 101, "a/b", ""])
def test_a_vehicle_needs_a_name_that_fits_into_a_path(client, name):
    text = client.get("/v1/vehicles/omnimate").json()["toml"].replace('"omnimate"', f'"{name}"')
    answer = client.post("/v1/vehicles", content=text, headers={"Content-Type": "application/toml"})
    assert answer.status_code == 422
