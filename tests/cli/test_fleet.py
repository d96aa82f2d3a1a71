"""`omnimate fleet`: a store is written, processed, and reported."""

import shutil
import sys

import pytest

from omnimate.fleet.report import Change, format_onset, format_rate, format_size

pytest.importorskip("pyarrow")


def change(name, shape, per_day):
    days = ("2026-03-04", "2026-03-03", "2026-03-05")
    return Change("tug-0000", "tug", 20.0, name, 1.0, *days, shape, 0.02, 0.001, per_day)


def test_a_step_of_a_wheelbase_is_said_in_percent_and_gets_no_worse():
    step = change("wheelbase", "step", 0.0)
    assert format_onset(step) == "2026-03-04 (2026-03-03 to 2026-03-05)"
    assert format_size(step) == "+2.000 +- 0.196 %"
    assert format_rate(step) == "no more"


def test_a_ramp_of_a_joint_is_said_in_degrees_with_its_speed():
    ramp = change("joint_a", "ramp", 0.002)
    assert format_size(ramp).endswith("degrees")
    assert format_rate(ramp) == "+0.115 degrees"


def test_a_small_hall_goes_through_all_verbs(omnimate, accepted, tmp_path):
    store = tmp_path / "store"
    sizes = {"robots": 2, "days": 3, "minutes": 1, "faulty": 0, "places": 0, "length": 12, "width": 10}
    hall = [word for name, size in sizes.items() for word in (f"--{name}", size)]
    assert omnimate("fleet", "simulate", store, *hall).code == 0
    done = omnimate("fleet", "run", store, "--no-diagnose")
    assert (done.code, done.out) == (0, "6 recordings processed, 0 known before\n")
    done = accepted("fleet", "report", store, "--plots", tmp_path / "plots")
    assert done.out.startswith("2026-03-04: 2 recordings, 2 robots judged, 0 faulty, 0 bad places")
    assert (tmp_path / "plots" / "floor.png").exists()


def test_recordings_that_cannot_be_read_are_counted_and_named_with_exit_code_1(
    omnimate, small_drive, tmp_path
):
    store = tmp_path / "store"
    for name in ("good", "bytes", "vehicle", "poses"):
        shutil.copytree(small_drive, store / "robot=x" / "day=2026-03-02" / name)
    shutil.copytree(small_drive, store / "robot=x" / "day=2026-99-99" / "lap")
    broken = store / "robot=x" / "day=2026-03-02"
    (broken / "bytes" / "can.log").unlink()
    (broken / "bytes" / "can.log.gz").write_bytes(bytes(range(256)))
    (broken / "vehicle" / "vehicle.toml").write_text("name = 3\n")
    (broken / "poses" / "poses.csv").write_text("time\n1,2\n")
    for _ in range(2):
        result = omnimate("fleet", "run", store, "--no-diagnose")
        assert result.code == 1
        assert "; 3 could not be read" in result.out
        for name in ("bytes", "vehicle", "poses"):
            assert f"robot=x/day=2026-03-02/{name}: {name}/" in result.err
        assert "robot=x/day=2026-99-99: its day is no date" in result.err
        assert "good" not in result.err


@pytest.mark.parametrize(
    ("options", "missing"), [((), "no recording;"), (("--day", "2026-03-01"), "of 2026-03-01;")]
)
def test_a_folder_that_is_no_store_is_refused_with_what_was_expected_and_what_to_do(
    refused, tmp_path, options, missing
):
    sentence = refused("fleet", "run", tmp_path, *options)
    assert sentence.startswith(f"error: {tmp_path}: ")
    for words in (missing, "robot=NAME/day=YYYY-MM-DD/", "move yours there", "omnimate fleet simulate"):
        assert words in sentence


def test_parquet_that_is_missing_is_named_before_any_recording_is_processed(refused, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("omnimate.fleet.batch.run.recordings_in", None)
    assert "pip install 'omnimate[fleet]'" in refused("fleet", "run", tmp_path)
