"""`omnimate diagnose` and `omnimate simulate --effects`: from a mismatch to a better simulator."""

import errno
import json
import shutil

import pytest

from omnimate.effects import effect_named
from omnimate.effects.file import load_effects
from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    vehicle = reference_vehicle()
    worn = effect_named("wheel_diameter")("a.left", ratio=1.004)
    recording = simulate(
        vehicle, Truth(vehicle, seed=4, effects=(worn,)), figure_eight(1.0, 2), start_time=100.0
    )
    path = tmp_path_factory.mktemp("drive") / "worn"
    save_recording(recording, path)
    return path


def test_the_answer_the_report_and_the_effects_are_written(accepted, folder, tmp_path):
    names = {
        option: tmp_path / name
        for option, name in (("--json", "a.json"), ("--report", "a.html"), ("--effects-out", "a.toml"))
    }
    result = accepted("diagnose", str(folder), *(str(part) for pair in names.items() for part in pair))
    assert "left wheel of truck a" in result.out
    assert json.loads(names["--json"].read_text())["verdict"] == "mismatch"
    assert names["--report"].read_text().startswith("<!doctype html>")
    assert [one.name for one in load_effects(names["--effects-out"])] == ["wheel_diameter"]


@pytest.mark.parametrize(
    ("options", "answer"), [(["--report"], "left wheel of truck a"), (["--triage", "--json"], "mismatch: ")]
)
def test_the_answer_is_printed_although_a_file_cannot_be_written(
    omnimate, folder, tmp_path, monkeypatch, options, answer
):
    def full(path, _text):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr("omnimate.vehicle.atomic.write_text", full)
    result = omnimate("diagnose", folder, *options, tmp_path / "a.html")
    assert result.code == 1
    assert "a.html: No space left on device" in result.err
    assert answer in result.out


def test_triage_says_that_something_is_there_and_where(accepted, folder, tmp_path):
    result = accepted("diagnose", str(folder), "--triage", "--json", str(tmp_path / "a.json"))
    assert result.out.startswith("mismatch: Something stands out on ")
    answer = json.loads((tmp_path / "a.json").read_text())
    assert answer["verdict"] == "mismatch"
    assert answer["where"]["channels"]


def test_triage_of_each_folder_writes_beside_it(accepted, folder):
    result = accepted("diagnose", str(folder), "--triage", "--each")
    assert "mismatch: Something stands out" in result.out
    assert json.loads(folder.with_name("worn.triage.json").read_text())["verdict"] == "mismatch"


def test_each_goes_on_where_an_answer_cannot_be_written(omnimate, folder, tmp_path):
    first, second = (shutil.copytree(folder, tmp_path / name) for name in ("first", "second"))
    first.with_name("first.triage.json").symlink_to("/dev/full")
    result = omnimate("diagnose", first, second, "--triage", "--each")
    assert result.code == 1
    assert f"{first}.triage.json: No space left on device" in result.err
    assert [line.partition(": ")[0] for line in result.out.splitlines()] == [str(first), str(second)]
    assert json.loads(second.with_name("second.triage.json").read_text())["verdict"] == "mismatch"


def test_each_writes_the_answer_of_the_current_folder_beside_it(accepted, folder, tmp_path, monkeypatch):
    monkeypatch.chdir(shutil.copytree(folder, tmp_path / "lap"))
    accepted("diagnose", ".", "--triage", "--each")
    assert (tmp_path / "lap.triage.json").is_file()


def test_each_says_what_of_a_log_was_left_out(omnimate, folder, tmp_path):
    log = shutil.copytree(folder, tmp_path / "lap") / "can.log"
    log.write_text(log.read_text() + "no frame\n")
    result = omnimate("diagnose", log.parent, "--triage", "--each")
    assert result.code == 1
    assert "skipped: " in result.err
    assert "mismatch: " in result.out


def test_too_little_memory_is_a_sentence_that_says_what_to_do(omnimate, folder, monkeypatch):
    def fail(_recordings):
        raise MemoryError

    monkeypatch.setattr("omnimate.mismatch.triage.triage", fail)
    result = omnimate("diagnose", folder, "--triage")
    assert (result.code, result.out) == (1, "")
    assert result.err.startswith("error: this takes more memory than there is; give fewer or shorter rec")
