"""Recordings as zip files: kept whole, or refused before anything is written outside of their folder."""

import io
import tomllib
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark
from omnimate.service.errors import InvalidValueError, MediaTypeError, ServiceError, TooLargeError
from omnimate.service.recording_zip import MOST_FILES, pack, unpack
from omnimate.service.store.recordings import RecordingStore
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth

LIMIT = 100_000_000
REFUSED = tomllib.loads(
    (Path(__file__).parents[1] / "data" / "service" / "refused_zips.toml").read_text(encoding="utf-8")
)["case"]


def zipped(members):
    """Return a zip of members, given as name and content."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return buffer.getvalue()


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A folder with the recording of a small square each way."""
    vehicle = reference_vehicle()
    program = umbmark(0.5, 1, speed=0.4, link_length=vehicle.linkage.length)
    folder = tmp_path_factory.mktemp("recording") / "drive"
    save_recording(simulate(vehicle, Truth(vehicle, seed=3), program), folder)
    return folder


def test_a_packed_folder_is_unpacked_byte_for_byte(recording, tmp_path):
    folder = unpack(pack(recording), tmp_path, LIMIT)
    files = {path.name: path.read_bytes() for path in recording.iterdir()}
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == files


def test_a_recording_may_lie_in_a_folder_of_its_zip(recording, tmp_path):
    members = [(f"drive/{path.name}", path.read_bytes()) for path in recording.iterdir()]
    assert unpack(zipped(members), tmp_path, LIMIT) == tmp_path / "drive"


def test_the_row_of_an_upload_says_what_is_in_it(database, recording, tmp_path):
    content = pack(recording)
    store = RecordingStore(database, str(tmp_path), LIMIT)
    row = store.add_upload("hall 3", content)
    assert (row.name, row.vehicle, row.laps, row.size) == ("hall 3", "omnimate", 2, len(content))
    loaded = store.load(row)
    assert (loaded.source, len(loaded)) == ("hall 3", row.samples)
    assert loaded.time[-1] - loaded.time[0] == pytest.approx(row.seconds)


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case["message"][:40])
def test_a_zip_that_is_no_recording_is_refused_with_its_message(database, case, tmp_path):
    content = case["content"].encode() if "content" in case else zipped(case["members"])
    with pytest.raises(ServiceError) as caught:
        RecordingStore(database, str(tmp_path), LIMIT).add_upload("x", content)
    assert (caught.value.status, str(caught.value)) == (case["status"], case["message"])
    assert not list(tmp_path.iterdir())


def test_too_many_files_are_refused(tmp_path):
    members = [(f"{number}.txt", b"x") for number in range(MOST_FILES + 1)]
    with pytest.raises(TooLargeError, match=r"65 files; a recording folder has 64 at most"):
        unpack(zipped(members), tmp_path, LIMIT)


def test_a_zip_bomb_is_not_unpacked(tmp_path):
    bomb = zipped([("can.log", bytes(10_000_000))])
    assert len(bomb) < 20_000
    with pytest.raises(TooLargeError):
        unpack(bomb, tmp_path, 1_000_000)
    assert (tmp_path / "can.log").stat().st_size <= 1_000_000


def test_a_link_in_a_zip_leads_nowhere(tmp_path):
    link = zipfile.ZipInfo("can.log")
    link.external_attr = 0o120777 << 16
    with pytest.raises(InvalidValueError, match="leads out of the recording folder"):
        unpack(zipped([(link, "/etc/passwd")]), tmp_path, LIMIT)


@given(names=st.lists(st.text("abc./\\:", min_size=1, max_size=12), max_size=4, unique=True))
def test_no_name_in_a_zip_writes_outside_of_its_folder(names, tmp_path_factory):
    place = tmp_path_factory.mktemp("names")
    folder = place / "inside"
    folder.mkdir()
    with pytest.raises((InvalidValueError, MediaTypeError)):
        unpack(zipped((name, b"x") for name in names), folder, LIMIT)
    assert [path.name for path in place.iterdir()] == ["inside"]
