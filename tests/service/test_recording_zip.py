"""Recordings as zip files: kept whole, or refused before anything is written outside of their folder."""

import gzip
import io
import json
import os
import pickle
import shutil
import tracemalloc
import zipfile
from operator import attrgetter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.recordings.zipped import pack
from omnimate.service.errors import InvalidValueError, MediaTypeError, ServiceError, TooLargeError
from omnimate.service.recording_zip import MAX_FILES, unpack
from omnimate.service.store.recordings import RecordingStore, read_in_process, summarize
from tests.samples import broken
from tests.service.zips import zipped

LIMIT = 100_000_000
REFUSED = broken("service/refused_zips.toml")


def test_a_packed_folder_is_unpacked_byte_for_byte(recording_folder, recording_files, tmp_path):
    folder = unpack(pack(recording_folder), tmp_path, LIMIT)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == recording_files


def test_a_recording_may_lie_in_a_folder_of_its_zip_and_what_macos_adds_is_left_out(
    recording_files, tmp_path
):
    members = {f"drive/{name}": content for name, content in recording_files.items()}
    added = {f"__MACOSX/drive/._{name}": b"x" for name in recording_files}
    added |= {"drive/.DS_Store": b"x", ".DS_Store": b"x"}
    folder = unpack(zipped(members | added), tmp_path, LIMIT)
    assert {path.name for path in folder.iterdir()} == recording_files.keys()
    assert list(tmp_path.iterdir()) == [folder] == [tmp_path / "drive"]


def test_an_encrypted_zip_is_refused_with_what_to_do(tmp_path):
    content = bytearray(zipped([("can.log", b"x")]))
    for begin, flags in ((b"PK\1\2", 8), (b"PK\3\4", 6)):  # of the directory, and of the file itself
        content[content.index(begin) + flags] |= 1
    says = r"^the zip cannot be read: 'can\.log' is encrypted; zip it without a password$"
    with pytest.raises(MediaTypeError, match=says):
        unpack(bytes(content), tmp_path, LIMIT)


@pytest.mark.parametrize("file", ["vehicle.toml", "poses.csv", "run.toml"])
def test_a_file_in_another_encoding_is_named_with_what_to_do(recording_folder, file, tmp_path):
    shutil.copytree(recording_folder, tmp_path, dirs_exist_ok=True)
    (tmp_path / file).write_bytes(b"# Gr\xf6\xdfe")
    with pytest.raises(InvalidValueError, match=rf"{file}.*: byte 5 is not UTF-8; save the file as UTF-8$"):
        read_in_process(tmp_path.parent, tmp_path, "drive", summarize)


@pytest.mark.parametrize("name", ["", "a/b", "a\\b", "n" * 101])
def test_a_recording_of_a_robot_that_the_service_cannot_store_is_refused(
    database, recording_files, name, tmp_path
):
    """The rule is that of the vehicles over REST."""
    renamed = recording_files["vehicle.toml"].replace(b'"omnimate"', json.dumps(name).encode())
    members = recording_files | {"vehicle.toml": renamed}
    says = r"^recording: vehicle\.toml: name: .*; expected 1 to 100 characters, no slash$"
    with pytest.raises(InvalidValueError, match=says):
        RecordingStore(database, str(tmp_path), LIMIT).add_upload("x", zipped(members))


def test_the_row_of_an_upload_says_what_is_in_it(database, small_recording, recording_files, tmp_path):
    content = zipped(recording_files)
    store = RecordingStore(database, str(tmp_path), LIMIT)
    row = store.add_upload("hall 3", content)
    assert (row.name, row.vehicle, row.laps, row.size) == ("hall 3", "omnimate", 2, len(content))
    assert row.samples == len(small_recording)
    assert row.seconds == pytest.approx(small_recording.time[-1] - small_recording.time[0])
    assert store.read(row, attrgetter("source")) == "hall 3"


def test_an_upload_says_what_of_its_log_could_not_be_read(database, recording_files, tmp_path):
    """As the command does: a log that was cut off is read up to there."""
    members = dict(recording_files)
    packed = gzip.compress(members.pop("can.log"))
    store = RecordingStore(database, str(tmp_path), LIMIT)
    whole, cut = (
        store.add_upload("x", zipped(members | {"can.log.gz": log})) for log in (packed, packed[:-2000])
    )
    assert cut.samples < whole.samples
    assert whole.problems == []
    assert cut.problems[-1] == "zip/can.log.gz: the log ends early; it was read up to there"


def test_of_many_problems_of_a_log_the_first_lines_and_those_of_the_whole_are_kept(
    recording_folder, tmp_path
):
    shutil.copytree(recording_folder, tmp_path, dirs_exist_ok=True)
    with (tmp_path / "can.log").open("ab") as log:
        log.write(b"garbage\n" * 1200)
    _, problems = read_in_process(tmp_path.parent, tmp_path, "drive", summarize)
    assert len(problems) == 20
    assert "skipped: " in problems[0]
    assert problems[-1].endswith("skipped: 200 lines more")


def test_an_upload_takes_no_memory_for_its_samples_here(database, small_recording, recording_files, tmp_path):
    """They stay in the process that reads them; files are unpacked in blocks."""
    content, store = zipped(recording_files), RecordingStore(database, str(tmp_path), LIMIT)
    store.add_upload("first", content)  # loads modules, and fills caches
    sent = len(pickle.dumps(small_recording))  # if the samples went from one process to the other
    tracemalloc.start()
    store.add_upload("second", content)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < len(content) + sent


@pytest.mark.parametrize("case", REFUSED, ids=lambda case: case["message"][:40])
def test_a_zip_that_is_no_recording_is_refused_with_its_message(database, case, tmp_path):
    content = case["content"].encode() if "content" in case else zipped(case["members"])
    with pytest.raises(ServiceError) as caught:
        RecordingStore(database, str(tmp_path), LIMIT).add_upload("x", content)
    assert (caught.value.status, str(caught.value)) == (case["status"], case["message"])
    assert not list(tmp_path.iterdir())


def test_too_many_files_are_refused(tmp_path):
    members = [(f"{number}.txt", b"x") for number in range(MAX_FILES + 1)]
    with pytest.raises(TooLargeError, match=r"65 files; send 64 at most"):
        unpack(zipped(members), tmp_path, LIMIT)


@pytest.mark.parametrize(
    ("log", "says"),
    [
        (("can.log", bytes(10_000_000)), "10000001 bytes when unpacked; at most 1000000 are accepted"),
        (("can.log.gz", gzip.compress(bytes(10_000_000))), "can.log.gz: more than 5000000 lines"),
        (("can.log", gzip.compress(b"\n" * 10_000_000)), "can.log: more than 5000000 lines"),
    ],
    ids=["zip", "gz in zip", "lines"],
)
def test_a_bomb_is_refused_before_it_is_unpacked(log, says, tmp_path):
    bomb = zipped([("vehicle.toml", b"x"), log])
    assert len(bomb) < 20_000
    with pytest.raises(TooLargeError, match=says):
        unpack(bomb, tmp_path, 1_000_000)
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) < 20_000


def test_a_zip_is_refused_that_no_reader_unpacks_in_pieces(tmp_path):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_BZIP2) as archive:
        archive.writestr("vehicle.toml", bytes(10_000))
    with pytest.raises(MediaTypeError, match="packed by method 12; expected stored or deflated"):
        unpack(buffer.getvalue(), tmp_path, LIMIT)


def test_a_recording_that_takes_too_much_memory_is_refused(recording_folder):
    with pytest.raises(TooLargeError, match="takes more than 50 MB of memory"):
        read_in_process(recording_folder.parent, recording_folder, "drive", summarize, memory=50_000_000)


def test_a_recording_that_takes_too_long_is_refused(recording_folder, tmp_path):
    shutil.copy(recording_folder / "vehicle.toml", tmp_path)
    os.mkfifo(tmp_path / "can.log")  # whoever reads it waits for ever
    with pytest.raises(TooLargeError, match="was not read within 0 s"):
        read_in_process(tmp_path.parent, tmp_path, "drive", summarize, timeout=0.0)


def damaged_data():
    content = bytearray(zipped([("vehicle.toml", b"abc" * 100)]))
    content[42:45] = b"\xff" * 3  # behind the local header (30 bytes) and the name (12)
    return bytes(content)


def name_that_is_no_text():
    return zipped([("\u00e9", b"")]).replace("\u00e9".encode(), b"\xff\xff")


def empty_name():
    """A name ends at its first zero byte."""
    return zipped([("xcan.log", b"")]).replace(b"xcan.log", b"\0can.log")


@pytest.mark.parametrize(
    "content",
    [damaged_data(), name_that_is_no_text(), empty_name(), zipped([("vehicle.toml", b"")])[1:]],
    ids=["data", "name that is no text", "empty name", "offset before the first byte"],
)
def test_a_damaged_zip_is_refused(content, tmp_path):
    with pytest.raises(MediaTypeError, match=r"the zip cannot be read: (?!.*codec)"):
        unpack(content, tmp_path, LIMIT)


def test_a_link_in_a_zip_leads_nowhere(tmp_path):
    link = zipfile.ZipInfo("can.log")
    link.external_attr = 0o120777 << 16
    with pytest.raises(InvalidValueError, match="leads out of the recording folder"):
        unpack(zipped([(link, "/etc/passwd")]), tmp_path, LIMIT)


@pytest.mark.parametrize("name", ["n" * 300, "n" * 300 + "/can.log", "drive/" + "\u00e9" * 101])
def test_a_name_that_no_file_can_have_is_refused(name, tmp_path):
    with pytest.raises(InvalidValueError, match="expected names of 200 bytes at most"):
        unpack(zipped([("vehicle.toml", b"x"), (name, b"x")]), tmp_path, LIMIT)


def test_a_name_that_is_a_file_and_a_folder_is_refused(tmp_path):
    with pytest.raises(InvalidValueError, match=r"'can\.log' is a file and a folder"):
        unpack(zipped([("vehicle.toml", b"x"), ("can.log", b"x"), ("can.log/x", b"x")]), tmp_path, LIMIT)


@given(names=st.lists(st.text("abc./\\:", min_size=1, max_size=12), max_size=4, unique=True))
def test_no_name_in_a_zip_writes_outside_of_its_folder(names, tmp_path_factory):
    place = tmp_path_factory.mktemp("names")
    folder = place / "inside"
    folder.mkdir()
    with pytest.raises((InvalidValueError, MediaTypeError)):
        unpack(zipped((name, b"x") for name in names), folder, LIMIT)
    assert [path.name for path in place.iterdir()] == ["inside"]
