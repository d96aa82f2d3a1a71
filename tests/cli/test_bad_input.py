"""What a user gets wrong is said in one sentence, exits with 1, and leaves nothing half-written."""

import shutil
from pathlib import Path

import pytest

from omnimate.files.recordings.folder import load_recording

READERS = [["replay"], ["umbmark"], ["calibrate"], ["track"], ["listen"], ["monitor"], ["dump"]]


@pytest.fixture
def drive(small_drive, tmp_path):
    """A small recording folder that a test may change."""
    return shutil.copytree(small_drive, tmp_path / "drive")


@pytest.mark.parametrize("verb", READERS)
def test_a_truncated_log_is_used_as_far_as_it_goes_and_marked(refused, drive, verb):
    log = drive / "can.log"
    content = log.read_bytes()
    log.write_bytes(content[: -len(content) // 500 - 7])
    assert "the log ends early" in refused(*verb, drive)


@pytest.mark.parametrize("verb", READERS)
def test_a_line_of_garbage_is_skipped_with_its_number(omnimate, drive, verb):
    log = drive / "can.log"
    lines = log.read_text().splitlines(keepends=True)
    lines.insert(41, "segmentation fault (core dumped)\n")
    log.write_text("".join(lines))
    result = omnimate(*verb, drive)
    assert result.code == 1
    assert "can.log:42: skipped" in result.err
    assert result.out, "what can be said is said all the same"


@pytest.mark.slow
def test_a_silent_bus_names_the_node_that_is_missing(said, tmp_path):
    sentence = said("record", tmp_path / "out", "--bus", "virtual://nobody-here")
    assert "node 1" in sentence
    assert "a.left" in sentence
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "call",
    [
        "record {drive} --bus virtual://any",
        "simulate {drive} --side 1 --runs 1",
        "import csv {drive}/poses.csv {drive} --mapping {drive}/run.toml",
    ],
)
def test_a_folder_that_holds_a_recording_is_not_overwritten(said, drive, call):
    before = load_recording(drive).counts
    assert "holds a recording" in said(*call.format(drive=drive).split())
    assert (load_recording(drive).counts == before).all()


@pytest.mark.skipif(not Path("/dev/full").is_char_device(), reason="no device here is always full")
def test_a_disk_that_is_full_is_said_without_a_traceback(said, drive):
    sentence = said("replay", drive, "--csv", "/dev/full")
    assert sentence == "/dev/full: No space left on device\n"
    assert Path("/dev/full").is_char_device()


@pytest.mark.parametrize("verb", [("dump",), ("scan",), ("record", "out"), ("monitor", "--seconds", "1")])
def test_udp_multicast_without_msgpack_names_its_extra(said, monkeypatch, tmp_path, verb):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("can.interfaces.udp_multicast.utils.msgpack", None)
    sentence = said(*verb, "--bus", "udp_multicast://239.74.163.2?port=43117")
    assert "pip install 'omnimate[multicast]'" in sentence
