"""Recordings as zips: kept whole, or refused before anything is written outside of their folder."""

import io
import zipfile

import pytest

from motion.paths import umbmark
from service.errors import TooLargeError
from service.recordings import pack, unpack
from vcan_sim.reference import reference_vehicle
from vcan_sim.simulate import simulate
from vcan_sim.truth import Truth, uncalibrated
from vehicle.folder import save_recording

PATH = "/v1/recordings"
ZIP = {"Content-Type": "application/zip"}


@pytest.fixture(scope="module")
def squares(tmp_path_factory):
    """A simulated recording of one square each way, as a zip."""
    vehicle = reference_vehicle()
    program = umbmark(2.0, 1, speed=0.4, link_length=vehicle.linkage.length)
    folder = tmp_path_factory.mktemp("squares") / "drive"
    save_recording(simulate(vehicle, Truth(uncalibrated(vehicle), seed=3), program), folder)
    return pack(folder)


def zipped(**members):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name.replace("__", "/"), content)
    return buffer.getvalue()


def test_a_recording_is_kept_byte_for_byte_until_it_is_deleted(service, squares):
    made = service.post(PATH, params={"name": "hall 3"}, content=squares, headers=ZIP)
    assert made.status_code == 201
    assert (made.json()["vehicle"], made.json()["laps"], made.json()["name"]) == ("omnimate", 2, "hall 3")
    own = made.headers["Location"]
    assert service.get(f"{own}/download").content == squares
    assert service.get(own).json() == made.json()
    assert service.delete(own).status_code == 200
    assert service.get(own).status_code == 404


def test_a_session_takes_every_square_of_a_recording(service, squares, started):
    recording = service.post(PATH, content=squares, headers=ZIP).json()["id"]
    path = started(service, how="recordings", side=2.0)
    answer = service.post(f"{path}/samples", json={"recording": recording})
    assert answer.status_code == 201
    assert [one["direction"] for one in service.get(path).json()["samples"]] == ["cw", "ccw"]
    found = service.post(f"{path}/solve").json()["trucks"]["a"]["calibrated"]["wheelbase"]
    assert found == pytest.approx(0.33617, abs=0.001)


def test_a_recording_of_another_robot_is_refused(client, squares, started):
    with zipfile.ZipFile(io.BytesIO(squares)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["vehicle.toml"] = members["vehicle.toml"].replace(b'"omnimate"', b'"another"')
    recording = client.post(PATH, content=zipped(**members), headers=ZIP).json()["id"]
    path = started(client, how="recordings", side=2.0)
    answer = client.post(f"{path}/samples", json={"recording": recording})
    assert answer.status_code == 422
    assert "'another'" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("content", "status", "words"),
    [
        (b"no zip", 415, "zip a recording folder"),
        (zipped(**{"..__..__evil": b"x"}), 422, "leads out of the recording folder"),
        (zipped(__etc__passwd=b"x"), 422, "leads out of the recording folder"),
        (zipped(**{"C:evil": b"x"}), 422, "leads out of the recording folder"),
        (zipped(**{"readme.txt": b"x"}), 422, "no recording in it"),
        (zipped(**{f"{n}.txt": b"x" for n in range(65)}), 413, "65 files"),
        (zipped(**{"vehicle.toml": b"name = 3"}), 422, "vehicle.toml"),
    ],
)
def test_a_zip_that_is_no_recording_is_refused_with_a_sentence(client, content, status, words):
    answer = client.post(PATH, content=content, headers=ZIP)
    assert answer.status_code == status
    assert words in answer.json()["detail"]


def test_a_zip_bomb_is_not_unpacked(tmp_path):
    bomb = zipped(**{"can.log": bytes(10_000_000)})
    assert len(bomb) < 20_000
    with pytest.raises(TooLargeError):
        unpack(bomb, tmp_path, 1_000_000)
    assert (tmp_path / "can.log").stat().st_size <= 1_000_000


def test_a_link_in_a_zip_leads_nowhere(client):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        link = zipfile.ZipInfo("can.log")
        link.external_attr = 0o120777 << 16
        archive.writestr(link, "/etc/passwd")
    assert client.post(PATH, content=buffer.getvalue(), headers=ZIP).status_code == 422


def test_two_gigabytes_are_refused_before_they_are_sent(client):
    answer = client.post(PATH, content=b"x", headers=ZIP | {"Content-Length": "2000000000"})
    assert answer.status_code == 413
    assert "at most 200000000" in answer.json()["detail"]


def test_a_body_that_does_not_say_how_long_it_is_ends_at_the_limit(client):
    answer = client.post("/v1/umbmark/sessions", content=(bytes(100_000) for _ in range(20)),
                         headers={"Content-Type": "application/json"})  # fmt: skip
    assert answer.status_code == 413
