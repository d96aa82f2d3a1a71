"""`omnimate export` and `import log`: from the command line to the files of other tools and back."""

import sys

import pytest

from omnimate.files.recordings.folder import load_recording


def test_a_recording_becomes_every_format(accepted, small_drive, tmp_path):
    for name in ("a.mcap", "a.parquet", "a.tum", "a.pcap", "a.blf", "a.asc", "a.csv", "a.log.gz", "bag"):
        assert "written:" in accepted("export", small_drive, tmp_path / name).out
    assert {path.name for path in tmp_path.glob("a-*")} >= {"a-poses.parquet", "a-ipec_b.tum"}
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("suffix", [".pcap", ".blf", ".csv", ".log.gz"])
def test_there_and_back_is_the_same_recording(omnimate, accepted, small_drive, tmp_path, suffix):
    omnimate("export", small_drive, tmp_path / f"bus{suffix}")
    vehicle = small_drive / "vehicle.toml"
    accepted("import", "log", tmp_path / f"bus{suffix}", tmp_path / "back", "--vehicle", vehicle)
    assert (tmp_path / "back" / "can.log").read_bytes() == (small_drive / "can.log").read_bytes()
    assert load_recording(tmp_path / "back").counts.tolist() == load_recording(small_drive).counts.tolist()


def test_a_log_with_a_vehicle_is_a_drive(omnimate, refused, small_drive, tmp_path):
    log = small_drive / "can.log"
    assert "give --vehicle" in refused("export", log, tmp_path / "a.tum")
    assert omnimate("export", log, tmp_path / "a.tum", "--vehicle", small_drive / "vehicle.toml").code == 0
    assert (tmp_path / "a-odometry_b.tum").exists()


def test_what_a_format_cannot_hold_is_told_and_gives_exit_code_1(omnimate, refused, tmp_path):
    (tmp_path / "fd.log").write_text("(1.000000) can0 181#01\n(1.100000) can0 181##1" + 12 * "00" + "\n")
    assert "1 frames left out: python-can's CSV holds no CAN FD frames" in refused(
        "export", tmp_path / "fd.log", tmp_path / "a.csv"
    )
    assert omnimate("export", tmp_path / "fd.log", tmp_path / "a.pcap").code == 0


def test_a_log_is_not_overwritten_by_its_export(refused, small_drive):
    log = small_drive / "can.log"
    before = log.read_bytes()
    for source in (log, small_drive):
        assert "is the log that is read" in refused("export", source, log)
    assert log.read_bytes() == before


@pytest.mark.parametrize(
    ("library", "name", "extra"),
    [
        ("mcap.writer", "a.mcap", "mcap"),
        ("rosbags.typesys", "bag", "rosbag"),
        ("pyarrow", "a.parquet", "parquet"),
    ],
)
def test_a_library_that_is_missing_is_named_with_its_extra_before_anything_is_read(
    refused, small_drive, tmp_path, monkeypatch, library, name, extra
):
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.setattr("omnimate.files.recordings.folder.read_recording", None)  # nothing is computed before
    monkeypatch.setattr("omnimate.files.logs.blocks.LogStream", None)  # nor read
    for source in (small_drive, small_drive / "can.log"):
        assert f"pip install 'omnimate[{extra}]'" in refused("export", source, tmp_path / name)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("name", ["a.mcap", "a.parquet", "a.tum", "a.pcap", "a.log.gz", "bag"])
def test_a_place_that_cannot_be_written_is_told(refused, small_drive, tmp_path, name):
    (tmp_path / "file").write_text("no folder")
    assert "cannot be written" in refused("export", small_drive, tmp_path / "file" / name)


def test_mf4_without_its_library_names_the_extra(refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "asammdf", None)
    (tmp_path / "a.mf4").write_bytes(b"MDF     4.10    ")
    assert "pip install 'omnimate[mf4]'" in refused("export", tmp_path / "a.mf4", tmp_path / "a.log")
