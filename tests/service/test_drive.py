"""The service drives the simulated robot: squares for a session, stop at any time, one session at once."""

import time

import pytest

from omnimate.service.store.tables import SessionRow
from tests.service.conftest import LONG_DRIVE, SESSIONS, sampled, started, until

DRIVE = {"how": "drive", "side": 1.0, "runs": 1}


@pytest.fixture
def standing(client):
    """A service whose robot does not drive, before and after the test."""
    yield client
    client.post("/v1/robot/stop")
    until(lambda: client.get("/v1/robot").json()["driving"] is None)


def test_a_driven_session_takes_its_own_samples_of_both_trucks(standing):
    path = started(standing, **DRIVE)
    until(lambda: standing.get(path).json()["state"] != "driving", 0.2)
    session = standing.get(path).json()
    assert session["state"] == "collecting", session["detail"]
    runs = session["samples"]
    assert [run["direction"] for run in runs] == ["cw", "ccw"]
    assert all(set(run["errors"]) == {"a", "b"} for run in runs)
    kept = standing.get(f"/v1/recordings/{runs[0]['recording']}").json()
    assert (kept["laps"], kept["vehicle"]) == (1, "omnimate")
    trucks = standing.post(f"{path}/solve").json()["trucks"]
    assert trucks["a"]["calibrated"]["wheelbase"] < 0.34 < trucks["b"]["calibrated"]["wheelbase"]


def test_a_run_that_is_removed_can_be_driven_again(standing):
    """The session said that all squares are driven, and could only be aborted."""
    path = started(standing, **DRIVE)
    until(lambda: standing.get(path).json()["state"] != "driving", 0.2)
    standing.delete(f"{path}/samples/2")
    session = standing.get(path).json()
    assert (session["state"], session["detail"]) == ("interrupted", "interrupted: run 2 was removed")
    standing.post(f"{path}/resume")
    until(lambda: standing.get(path).json()["state"] != "driving", 0.2)
    session = standing.get(path).json()
    assert (session["state"], [run["direction"] for run in session["samples"]]) == (
        "collecting",
        ["cw", "ccw"],
    )


def test_a_stop_before_the_first_sample_of_a_drive_is_not_lost(standing, monkeypatch):
    reservation = standing.components.robot.reservation
    begin = reservation.begin

    def begin_and_stop(order):
        begun = begin(order)
        reservation.stop("stopped at once")
        return begun

    monkeypatch.setattr(reservation, "begin", begin_and_stop)
    path = started(standing, **DRIVE)
    for _ in range(2):
        until(lambda: standing.get(path).json()["state"] != "driving")
        session = standing.get(path).json()
        assert (session["state"], session["detail"]) == ("interrupted", "interrupted: stopped at once")
        assert standing.post(f"{path}/resume").json()["state"] == "driving"


def test_a_robot_that_was_stopped_in_mid_square_drives_home_and_goes_on(standing):
    path = started(standing, **DRIVE | {"side": 4.0, "runs": 50})  # more than it drives before the stop
    until(lambda: standing.get(path).json()["counts"]["cw"])
    until(lambda: abs(standing.get("/v1/robot").json()["state"]["plain"]["theta"]) > 1.5)
    standing.post("/v1/robot/stop")
    until(lambda: standing.get(path).json()["state"] == "interrupted")
    assert "stop" in standing.get(path).json()["detail"]
    before = sum(standing.get(path).json()["counts"].values())
    standing.post(f"{path}/resume")
    until(lambda: sum(standing.get(path).json()["counts"].values()) > before)


def test_only_one_session_drives(standing):
    started(standing, **LONG_DRIVE)
    answer = standing.post(SESSIONS, json=DRIVE)
    assert answer.status_code == 409
    assert "drives for session" in answer.json()["detail"]


def test_a_session_whose_service_has_died_is_interrupted(standing):
    path = started(standing)
    with standing.components.database.writing() as db:
        row = db.get(SessionRow, path.rpartition("/")[2])
        row.how, row.state, row.owner, row.lease = "drive", "driving", "another", time.time() - 1.0
    until(lambda: standing.get(path).json()["state"] == "interrupted")
    assert "resume" in standing.get(path).json()["possible"]


def test_accepting_gives_the_robot_its_new_parameters(standing):
    path = started(standing)
    sampled(standing, path)
    standing.post(f"{path}/solve")
    before = standing.get("/v1/robot").json()["samples"]
    standing.post(f"{path}/accept", headers={"If-Match": "*"})
    until(lambda: standing.get("/v1/robot").json()["samples"] > before + 10)
    assert standing.get("/readyz").status_code == 200


def test_the_bus_is_reported_node_by_node_and_frame_by_frame(standing):
    until(lambda: len(standing.get("/v1/bus").json()["nodes"]) == 11)
    bus = standing.get("/v1/bus").json()
    assert {node["names"][0] for node in bus["nodes"]} >= {"a.left", "link", "drive of b.right"}
    lines = standing.get("/v1/bus/frames", params={"count": 20}).text.splitlines()
    assert len(lines) == 20
    assert any(" can0 080#" in line for line in lines)
    until(lambda: standing.get("/v1/robot/errors").json() == {"errors": []})
    assert standing.get("/v1/robot/errors", params={"format": "open-rmf"}).json() == {"issues": []}
