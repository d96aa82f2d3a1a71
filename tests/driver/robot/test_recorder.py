import errno
import os

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot import recorder as recorder_module
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.files.recordings.poses_csv import read_poses
from omnimate.files.recordings.run_toml import read_run
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import load_vehicle


def drive(kit, folder, cycles=20, **kwargs):
    samples, recorder = [], Recorder(folder, kit.one_truck(), **kwargs)
    driver, bus = kit.driver_and_bus(recorder=recorder)
    with recorder, driver:
        driver.configure()
        for step in range(cycles):
            for device in bus.devices.values():
                device.position = 10 * step
            samples.append(driver.cycle())
    return samples, recorder


def test_every_frame_is_there_in_order_sent_and_received(kit, tmp_path):
    drive(kit, tmp_path / "run", cycles=1)
    lines = (tmp_path / "run" / "can.log").read_text().splitlines()
    assert lines[0].split()[2] == "601#4000100000000000"
    assert [line.split()[2] for line in lines[-3:]] == ["080#", "181#00000000", "182#00000000"]
    times = [float(line.split()[0].strip("()")) for line in lines]
    assert times == sorted(times)


@given(times=st.lists(st.floats(1e9, 2e9), max_size=20))
def test_the_log_never_steps_backwards(kit, tmp_path_factory, times):
    folder = tmp_path_factory.mktemp("run")
    with Recorder(folder, kit.one_truck()) as recorder:
        for time in times:
            recorder.frame(time, kit.frame(0x080))
    written = [float(line.split()[0].strip("()")) for line in (folder / "can.log").read_text().splitlines()]
    assert written == sorted(written)
    assert len(written) == len(times)


def test_the_vehicle_file_holds_the_ranges_that_were_found(kit, tmp_path):
    recorder = Recorder(tmp_path, kit.one_truck())
    driver, bus = kit.driver_and_bus(recorder=recorder)
    bus.devices[1].put(0x6002, 0, 4095)
    assert load_vehicle(tmp_path / "vehicle.toml").encoder("a.left").range is None
    driver.configure()
    recorder.close()
    assert load_vehicle(tmp_path / "vehicle.toml").encoder("a.left").range == 4096


def test_laps_and_poses_are_on_disk_as_they_come(kit, tmp_path):
    drive(kit, tmp_path / "run")
    recorder = Recorder(tmp_path / "other", kit.one_truck(), protocol="umbmark", side=4.0)
    (tmp_path / "run" / "can.log").replace(tmp_path / "other" / "can.log")
    recorder.lap("cw", 100.02, 100.05)
    recorder.lap("ccw", 100.06, 100.1)
    recorder.pose(100.03, "a", (1.0, 2.0, 0.5), (0.01, 0.01, float("nan")))
    recording = load_recording(tmp_path / "other")
    recorder.close()
    assert recording.run is not None
    assert recording.poses is not None
    assert (recording.run.protocol, recording.run.side) == ("umbmark", 4.0)
    assert [lap.direction for lap in recording.run.laps] == ["cw", "ccw"]
    assert recording.poses.pose.tolist() == [[1.0, 2.0, 0.5]]


def test_a_recording_is_never_overwritten(kit, tmp_path):
    drive(kit, tmp_path, cycles=1)
    with pytest.raises(RecordingError, match="holds a recording"):
        Recorder(tmp_path, kit.one_truck())


def test_a_folder_that_cannot_be_made_is_an_error(kit, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path / "file" / "run", kit.one_truck())


def test_foreign_frames_are_recorded_as_what_they_are(kit, tmp_path):
    with Recorder(tmp_path, kit.one_truck()) as recorder:
        recorder.frame(1.0, can.Message(arbitration_id=0x18FF1234, data=b"\x01"))
        recorder.frame(2.0, kit.frame(0x701, is_remote_frame=True, dlc=1))
        recorder.frame(3.0, kit.frame(0x181))
    content = [line.split()[2] for line in (tmp_path / "can.log").read_text().splitlines()]
    assert content == ["18FF1234#01", "701#R1", "181#"]


def refuse(*_arguments):
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_driver_goes_on_when_the_disk_is_full_and_reports_once_how_many_frames_are_missing(
    kit, tmp_path, monkeypatch
):
    writer = recorder_module.CandumpWriter
    monkeypatch.setattr(
        recorder_module, "CandumpWriter", lambda _path: writer("/dev/full", sync_interval=3600.0)
    )
    recorder = Recorder(tmp_path, kit.one_truck())
    with kit.driver_and_bus(recorder=recorder)[0] as driver:
        driver.configure()
        samples = [driver.cycle() for _ in range(500)]
        (problem,) = driver.report().problems
    assert all(all(sample.present) for sample in samples)
    assert problem.what == "recording: No space left on device; frames are missing from it"
    assert problem.count > 1000
    assert problem.last == pytest.approx(samples[-1].time, abs=0.01)
    with pytest.raises(RecordingError, match="its end cannot be written: No space left"):
        recorder.close()


def test_laps_and_poses_that_a_full_disk_refuses_are_written_when_there_is_space(kit, tmp_path, monkeypatch):
    recorder = Recorder(tmp_path, kit.one_truck())
    with monkeypatch.context() as full:
        full.setattr(os, "fsync", refuse)
        recorder.lap("cw", 100.0, 100.05)
        recorder.pose(100.03, "a", (1.0, 2.0, 0.5), (0.01, 0.01, 0.1))
        assert not (tmp_path / "run.toml").exists()
    recorder.close()
    assert len(read_run(tmp_path / "run.toml").laps) == 1
    assert len(read_poses(tmp_path / "poses.csv").time) == 1
