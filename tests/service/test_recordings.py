"""Recordings over REST: uploaded, listed, downloaded, deleted, and taken as the runs of a session."""

import io
import zipfile

import pytest

from tests.service.conftest import ZIP, drive_zip, started, uploaded
from tests.service.zips import zipped

PATH = "/v1/recordings"


def test_a_recording_is_kept_byte_for_byte_until_it_is_deleted(service):
    squares = drive_zip(2.0)
    made = service.post(PATH, params={"name": "hall 3"}, content=squares, headers=ZIP)
    assert made.status_code == 201
    assert (made.json()["vehicle"], made.json()["laps"], made.json()["name"]) == ("omnimate", 2, "hall 3")
    location = made.headers["Location"]
    assert service.get(f"{location}/download").content == squares
    assert service.get(location).json() == made.json()
    assert service.delete(location).status_code == 200
    assert service.get(location).status_code == 404


def test_a_session_takes_every_square_of_a_recording(service):
    recording = uploaded(service, drive_zip(2.0))
    path = started(service, how="recordings", side=2.0)
    answer = service.post(f"{path}/samples", json={"recording": recording})
    assert answer.status_code == 201
    assert [run["direction"] for run in service.get(path).json()["samples"]] == ["cw", "ccw"]
    wheelbase = service.post(f"{path}/solve").json()["trucks"]["a"]["calibrated"]["wheelbase"]
    assert wheelbase == pytest.approx(0.33617, abs=0.001)


def test_a_session_takes_the_runs_of_a_recording_once_until_they_are_removed(service):
    body = {"recording": uploaded(service, drive_zip(2.0))}
    path = started(service, how="recordings", side=2.0)
    assert service.post(f"{path}/samples", json=body).status_code == 201
    again = service.post(f"{path}/samples", json=body)
    assert (again.status_code, again.json()["possible"]) == (409, ["sample", "remove", "solve", "abort"])
    assert "is in session" in again.json()["detail"]
    assert len(service.get(path).json()["samples"]) == 2
    for number in (1, 2):
        service.delete(f"{path}/samples/{number}")
    assert service.post(f"{path}/samples", json=body).status_code == 201


def test_a_recording_of_another_robot_is_refused(client):
    with zipfile.ZipFile(io.BytesIO(drive_zip(2.0))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["vehicle.toml"] = members["vehicle.toml"].replace(b'"omnimate"', b'"another"')
    recording = client.post(PATH, content=zipped(members), headers=ZIP).json()["id"]
    path = started(client, how="recordings", side=2.0)
    answer = client.post(f"{path}/samples", json={"recording": recording})
    assert answer.status_code == 422
    assert "'another'" in answer.json()["detail"]


def test_a_key_stands_for_one_query(service):
    def upload(name):
        headers = ZIP | {"Idempotency-Key": "one upload"}
        return service.post("/v1/recordings", params={"name": name}, content=drive_zip(0.5), headers=headers)

    long = "\N{ROBOT FACE}" * 100  # 1200 characters of a query
    first = upload(long)
    assert (first.status_code, first.json()["name"]) == (201, long)
    assert upload("another").status_code == 409
    assert upload(f"{long[:-1]}!").status_code == 409
    assert upload(long).json() == first.json()
