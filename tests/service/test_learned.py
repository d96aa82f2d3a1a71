"""What the filter has learned: seen of a recording and live, and made a vehicle's version by one request."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.motion.paths import squares
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.file import parse_vehicle
from tests.service.conftest import ZIP, biased_zip, until, zip_of

VEHICLE = "/v1/vehicles/omnimate"
NOT_TOLD = {"wheelbase of a", "wheelbase of b", "bias of joint_a", "bias of joint_b"}


def stored(client, content):
    made = client.post("/v1/recordings", content=content, headers=ZIP)
    assert made.status_code == 201, made.text
    return f"{made.headers['Location']}/learned"


def test_a_biased_joint_is_named_with_its_value_and_what_it_may_be_instead(service):
    learned = service.get(stored(service, biased_zip())).json()
    assert [wrong["name"] for wrong in learned["suspects"]] == ["bias of joint_a"]
    (bias,) = (value for value in learned["values"] if value["name"] == "joint_a bias")
    assert (bias["unit"], bias["described"]) == ("rad", 0.0)
    assert np.degrees(bias["value"]) == pytest.approx(0.5, abs=0.05)
    assert 0.0 < np.degrees(bias["sigma"]) < 0.1
    assert learned["misread"] == []
    said = " ".join(advice["do"] for advice in learned["advice"])
    assert "an axle that is turned in its truck looks the same" in said
    assert "measure a straight" in said


def test_what_was_learned_becomes_the_next_version_only_where_the_version_before_it_is_meant(service):
    path = stored(service, biased_zip())
    now = service.get(VEHICLE).json()
    number = service.get(path).json()["vehicle_version"]
    assert number == now["version"]
    assert service.post(f"{path}/accept").status_code == 428
    wrong = service.post(f"{path}/accept", headers={"If-Match": '"77"'})
    assert (wrong.status_code, "not 77" in wrong.json()["detail"]) == (412, True)
    made = service.post(f"{path}/accept", headers={"If-Match": f'"{number}"'})
    assert made.status_code == 200, made.text
    assert made.headers["ETag"] == f'"{number + 1}"'
    zeros = [parse_vehicle(view["toml"], "test").encoder("joint_a") for view in (now, made.json())]
    moved = (zeros[1].zero - zeros[0].zero) * zeros[0].scale
    assert moved == pytest.approx(np.radians(0.5), abs=0.75 * abs(zeros[0].scale))
    again = service.post(f"{path}/accept", headers={"If-Match": "*"})
    assert again.status_code == 412, "the robot of the recording drove by a version that is not the newest"


def test_what_cannot_be_learned_is_refused(client):
    robot = reference_single()
    single = zip_of(simulate(robot, Truth(robot), squares(["cw"], 0.5)))
    assert client.get(stored(client, single)).status_code == 422
    assert client.get("/v1/recordings/none/learned").status_code == 404


def test_a_robot_that_the_service_does_not_have_is_shown_and_cannot_be_accepted(client):
    robot = replace(reference_vehicle(), name="stranger")
    recording = simulate(robot, Truth(robot), squares(["cw"], 0.5, link_length=robot.linkage.length))
    path = stored(client, zip_of(recording))
    assert client.get(path).json()["vehicle_version"] is None
    refused = client.post(f"{path}/accept", headers={"If-Match": "*"})
    assert refused.status_code == 409
    assert "POST or PUT its vehicle.toml" in refused.json()["detail"]


def test_the_live_robot_says_what_it_has_learned_and_what_no_drive_has_told_yet(client):
    until(lambda: client.get("/v1/robot/learned").status_code == 200)
    learned = client.get("/v1/robot/learned").json()
    number = client.get(VEHICLE).json()["version"]
    assert (learned["vehicle"], learned["vehicle_version"]) == ("omnimate", number)
    assert set(learned["untold"]) >= NOT_TOLD
    assert any("short radius" in advice["do"] for advice in learned["advice"])
    made = client.post("/v1/robot/learned/accept", headers={"If-Match": f'"{number}"'})
    assert made.status_code == 200, made.text
    assert (made.json()["version"], made.json()["origin"]) == (number + 1, "learned on the way")
    until(lambda: client.get("/v1/robot/learned").json().get("vehicle_version") == number + 1)
