"""Diagnoses as jobs: done in a process of their location, retried when it dies, never stuck."""

import multiprocessing
import time

import pytest

from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark
from omnimate.service.recording_zip import pack
from omnimate.service.store.tables import JobRow
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth

PATH = "/v1/diagnoses"
ENDED = {"done", "failed", "cancelled"}


@pytest.fixture(scope="module")
def recording(client, tmp_path_factory):
    """The id of a short recording, which is too little to diagnose anything from."""
    vehicle = reference_vehicle()
    program = umbmark(0.5, 1, speed=0.4, link_length=vehicle.linkage.length)
    folder = tmp_path_factory.mktemp("short") / "drive"
    save_recording(simulate(vehicle, Truth(vehicle, seed=3), program), folder)
    sent = client.post("/v1/recordings", content=pack(folder), headers={"Content-Type": "application/zip"})
    return sent.json()["id"]


def test_a_diagnosis_is_done_and_can_be_read(client, recording, until):
    made = client.post(PATH, json={"recordings": [recording]})
    assert made.status_code == 202
    location = made.headers["Location"]
    assert client.get(f"{location}/result").status_code in {200, 409}
    until(lambda: client.get(location).json()["state"] in ENDED)
    job = client.get(location).json()
    assert (job["state"], job["progress"]) == ("done", 1.0)
    assert client.get(f"{location}/result").json()["verdict"] == job["verdict"]
    report = client.get(f"{location}/report")
    assert "<html" in report.text
    assert "sandbox" in report.headers["content-security-policy"]


def test_what_its_process_dies_of_is_tried_again_and_then_given_up(client, recording, until):
    location = client.post(PATH, json={"recordings": [recording]}).headers["Location"]

    def killed():
        for child in multiprocessing.active_children():
            child.kill()
        return client.get(location).json()["state"] in ENDED

    until(killed)
    job = client.get(location).json()
    assert (job["state"], job["attempts"]) == ("failed", 3)
    assert "given up after 3 attempts" in job["error"]


@pytest.mark.slow
def test_what_a_dead_service_worked_at_is_taken_up(client, recording, until):
    with client.components.database.writing() as db:
        db.add(
            JobRow(
                id="orphan", recordings=[recording], state="running", progress=0.5, doing="",
                attempts=1, created=time.time(), changed=time.time(), owner="another",
                lease=time.time() - 1.0,
            )
        )  # fmt: skip
    until(lambda: client.get(f"{PATH}/orphan").json()["state"] == "done")
    assert client.get(f"{PATH}/orphan").json()["attempts"] == 2


def test_a_cancelled_diagnosis_ends(client, recording, until):
    location = client.post(PATH, json={"recordings": [recording]}).headers["Location"]
    assert client.post(f"{location}/cancel").json()["state"] == "cancelled"
    assert client.post(f"{location}/cancel").status_code == 409
    until(lambda: not multiprocessing.active_children())
    assert client.get(location).json()["state"] == "cancelled"


def test_recordings_that_are_not_there_are_not_diagnosed(client):
    assert client.post(PATH, json={"recordings": ["none"]}).status_code == 404
    assert client.post(PATH, json={"recordings": []}).status_code == 422
