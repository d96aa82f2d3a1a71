"""The Python client with a service: sessions, conflicts, wrong values, lists and jobs, over HTTP."""

import shutil
import zipfile
from io import BytesIO

import pytest

from omnimate.client import Client, ProblemError
from tests.service.conftest import manual_runs, short_zip

QUICKLY = 0.02  # [s] between two looks at a job


@pytest.fixture(scope="module")
def api(url):
    """A client of a service in a process of its own."""
    return Client(url)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a recording."""
    unpacked = tmp_path_factory.mktemp("upload") / "lap"
    with zipfile.ZipFile(BytesIO(short_zip(0.5))) as archive:
        archive.extractall(unpacked)
    return unpacked


def test_a_session_by_hand_is_solved_and_makes_a_new_version(api):
    assert api.health.get_readiness() == {"status": "ok"}
    session = api.umbmark.start_session(how="manual", side=4.0, runs=2)["id"]
    for run in manual_runs(2):
        api.umbmark.add_sample(session, run)
    result = api.umbmark.solve_session(session, method="heading")
    assert result["method"] == "heading"
    before = api.vehicles.get_vehicle("omnimate")["version"]
    assert api.umbmark.get_plot(session, "png").startswith(b"\x89PNG")
    accepted = api.umbmark.accept_result(session, if_match=result["revision"])
    assert accepted["state"] == "accepted"
    assert api.vehicles.get_vehicle("omnimate")["version"] == before + 1
    assert api.vehicles.export_vehicle("omnimate", "ros2").startswith("diff_drive_controller_a:")


def test_a_wrong_value_is_a_problem_with_its_field(api):
    with pytest.raises(ProblemError) as caught:
        api.umbmark.start_session(side=0.1)
    assert caught.value.status == 422
    assert caught.value.errors == (("body.side", "0.1; expected 0.2 or more"),)
    assert caught.value.request_id


def test_a_list_goes_over_all_pages_newest_first(api):
    started = [api.umbmark.start_session(side=1.0)["id"] for _ in range(5)]
    listed = [session["id"] for session in api.umbmark.list_sessions(page_size=2)]
    assert listed[:5] == started[::-1]
    assert len(set(listed)) == len(listed)


def test_a_folder_is_uploaded_diagnosed_and_downloaded(api, folder):
    recording = api.recordings.upload_recording(str(folder), name="lap 1")
    assert recording["name"] == "lap 1"
    shown = []
    job = api.wait(api.diagnoses.start_diagnosis(recordings=[recording["id"]]), shown.append, every=QUICKLY)
    assert (job["state"], shown[-1]["progress"]) == ("done", 1.0)
    progress = [step["progress"] for step in shown]
    assert progress == sorted(progress)
    assert api.diagnoses.get_diagnosis_result(job["id"])["verdict"] == job["verdict"]
    assert "<html" in api.diagnoses.get_diagnosis_report(job["id"])
    with zipfile.ZipFile(BytesIO(api.recordings.download_recording(recording["id"]))) as archive:
        assert "vehicle.toml" in archive.namelist()


@pytest.mark.slow
def test_a_day_of_a_fleet_is_uploaded_as_a_folder_and_processed_as_a_batch(api, folder, tmp_path):
    target = tmp_path / "robot=tug-1" / "day=2026-03-02" / "lap"
    shutil.copytree(folder, target)
    api.fleets.create_fleet(name="hall")
    api.fleets.upload_day("hall", tmp_path)
    batch = api.wait(api.fleets.start_batch("hall", diagnose=False), every=QUICKLY)
    assert (batch["state"], batch["failures"], batch["done"]) == ("done", [], 1)
    assert [fleet["name"] for fleet in api.fleets.list_fleets()] == ["hall"]


def test_streams_yield_the_robot_and_the_frames_of_its_bus(api):
    stream, seen = api.robot.stream_robot(), {}
    while not seen.keys() >= {"state", "nodes"}:
        event = next(stream)
        seen[event.kind] = event.data
    assert (seen["state"]["mode"], len(seen["nodes"]["nodes"])) == ("simulated", 11)
    stream.close()
    frames = list(api.robot.stream_frames(count=3))
    assert len(frames) == 3
    assert all(frame.startswith("(") for frame in frames)
