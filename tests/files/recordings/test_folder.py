"""The recording folder: what is saved is loaded, and what is wrong is named with its place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.files.logs.frame_classes import count_classes
from omnimate.files.recordings.folder import load_recording, read_recording, save_recording
from omnimate.vehicle.errors import LogError, RecordingError, VehicleFileError
from omnimate.vehicle.file import parse_vehicle, save_vehicle
from omnimate.vehicle.parameters import Drive
from omnimate.vehicle.recording import Gap, Lap, Poses, Recording, Run

SAMPLES = 40
START = 1763670000.0


@pytest.fixture
def vehicle(robot_toml):
    return parse_vehicle(robot_toml)


def recording_of(vehicle, **changes):
    """A short drive whose counters wrap, with a fix and a lap."""
    count = changes.pop("samples", SAMPLES)
    index = np.arange(count)
    counts = np.outer(index, [37, 36, -35, -34, 1, -1, 2]).astype(np.int64)
    fields = {
        "vehicle": vehicle,
        "time": START + np.round(index * vehicle.bus.sync_period, 6),
        "counts": counts,
        "present": np.ones(counts.shape, bool),
        "poses": Poses(
            np.array([START, START + 0.3]),
            np.array(["a", "b"]),
            np.array([[1.0, -2.0, 3.1], [np.nan, 0.1, np.nan]]),
            np.array([[0.002, 0.002, 0.0052], [np.nan] * 3]),
        ),
        "run": Run("umbmark", 4.0, (Lap("cw", START, START + 0.3), Lap("none", START + 0.3, START + 0.4))),
    }
    return Recording(**(fields | changes))


def assert_equal(one, other):
    """Two recordings say the same."""
    assert (one.vehicle, one.run) == (other.vehicle, other.run)
    assert one.time == pytest.approx(other.time, abs=1e-6)
    assert np.array_equal(one.counts, other.counts)
    assert np.array_equal(one.present, other.present)
    assert (one.poses is None) == (other.poses is None)
    if one.poses is not None:
        for name in ("time", "body", "pose", "sigma"):
            np.testing.assert_array_equal(getattr(one.poses, name), getattr(other.poses, name))


@pytest.mark.parametrize("compress", [False, True])
def test_what_is_saved_is_loaded(vehicle, tmp_path, compress):
    recording = recording_of(vehicle)
    save_recording(recording, tmp_path / "new" / "folder", compress=compress)
    assert_equal(load_recording(tmp_path / "new" / "folder"), recording)


def test_saving_replaces_the_whole_recording_that_was_there(vehicle, tmp_path):
    save_recording(recording_of(vehicle), tmp_path, compress=True)
    bare = recording_of(vehicle, poses=None, run=None, samples=5)
    save_recording(bare, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["can.log", "vehicle.toml"]
    assert_equal(load_recording(tmp_path), bare)


def test_a_place_that_cannot_be_written_is_an_error(vehicle, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match="cannot be written"):
        save_recording(recording_of(vehicle), tmp_path / "file")


@pytest.mark.parametrize("time", [-5.0, 2.0**33])
def test_a_time_that_no_log_holds_is_refused_and_the_folder_stays_as_it_is(vehicle, tmp_path, time):
    before = recording_of(vehicle)
    save_recording(before, tmp_path)
    with pytest.raises(RecordingError, match="expected seconds since 1970"):
        save_recording(recording_of(vehicle, time=before.time - START + time), tmp_path)
    assert_equal(load_recording(tmp_path), before)


@settings(max_examples=25)
@given(data=st.data())
def test_any_drive_survives_the_bus(robot_toml, tmp_path, data):
    widths = data.draw(st.lists(st.integers(13, 32), min_size=7, max_size=7))
    text = robot_toml
    for width in widths:
        text = text.replace("bits = 32", f"bits = {width}", 1).replace("bits = ", "bits=", 1)
    vehicle = parse_vehicle(text)
    steps = data.draw(st.lists(st.tuples(*[st.integers(-60, 60)] * 7), min_size=1, max_size=20))
    counts = np.cumsum(np.array([(0,) * 7, *steps]), axis=0)
    absent = data.draw(st.lists(st.tuples(st.integers(1, len(steps)), st.integers(0, 6)), max_size=10))
    present = np.ones(counts.shape, bool)
    for row, column in absent:
        present[row, column] = False
    last = np.maximum.accumulate(np.where(present, np.arange(len(counts))[:, None], 0), axis=0)
    counts = np.take_along_axis(counts, last, axis=0)
    recording = recording_of(
        vehicle, samples=len(counts), counts=counts, present=present, poses=None, run=None
    )
    save_recording(recording, tmp_path)
    assert_equal(load_recording(tmp_path), recording)


def test_a_restart_survives_the_bus(vehicle, tmp_path):
    present = np.ones((SAMPLES, 7), bool)
    present[10:13, 0] = False
    counts = recording_of(vehicle).counts.copy()
    counts[10:13, 0] = counts[9, 0]  # the wheel goes on at 13 in proportion to the other one
    time = recording_of(vehicle).time
    gap = Gap("a.left", float(time[9]), float(time[13]), "reboot")
    recording = recording_of(vehicle, counts=counts, present=present, gaps=(gap,))
    save_recording(recording, tmp_path)
    loaded = read_recording(tmp_path)
    assert_equal(loaded.recording, recording)
    assert [(gap.channel, gap.reason) for gap in loaded.recording.gaps] == [("a.left", "reboot")]
    assert loaded.assembly.pdos[0].restarts == 1


def test_a_drive_on_a_clock_from_zero_survives_too(robot_toml, tmp_path):
    drives = (Drive("a.left", 11, 0x20B, 1, 40000.0),)
    vehicle = replace(parse_vehicle(robot_toml), drives=drives)
    time = recording_of(vehicle).time - START
    commands = np.ones((SAMPLES, 4))
    save_recording(recording_of(vehicle, time=time, commands=commands, poses=None, run=None), tmp_path)
    loaded = read_recording(tmp_path)
    assert loaded.log.blocks.is_whole
    assert loaded.recording.time[0] == 0.0


@pytest.mark.parametrize("start_bit", [0, 16, 32])
def test_commands_survive_the_bus_to_the_drives_resolution(robot_toml, tmp_path, start_bit):
    drives = tuple(
        Drive(wheel, 10 + index, 0x20A + index, (-1) ** index, 40000.0, start_bit=start_bit)
        for index, wheel in enumerate(("a.left", "a.right", "b.left", "b.right"))
    )
    vehicle = replace(parse_vehicle(robot_toml), drives=drives)
    commands = np.round(np.sin(np.outer(np.arange(SAMPLES), [0.1, 0.2, 0.0, 0.3])), 1)
    commands[:3] = np.nan
    save_recording(recording_of(vehicle, commands=commands), tmp_path)
    loaded = load_recording(tmp_path).commands
    assert loaded == pytest.approx(commands, abs=2 * np.pi / 40000, nan_ok=True)


def test_answers_come_between_one_sync_and_the_next(vehicle, tmp_path):
    save_recording(recording_of(vehicle), tmp_path)
    frames = read_recording(tmp_path).log.frames
    assert (np.diff(frames.time) >= 0.0).all()
    assert len(frames) == 8 * SAMPLES


@pytest.mark.parametrize(("name", "error"), [("vehicle.toml", VehicleFileError), ("can.log", RecordingError)])
def test_what_is_missing_is_named(vehicle, tmp_path, name, error):
    save_recording(recording_of(vehicle), tmp_path)
    (tmp_path / name).unlink()
    with pytest.raises(error, match=name):
        load_recording(tmp_path)
    with pytest.raises(RecordingError, match="no such folder"):
        load_recording(tmp_path / "nowhere")


def test_an_empty_log_is_an_error(vehicle, tmp_path):
    save_vehicle(vehicle, tmp_path / "vehicle.toml")
    (tmp_path / "can.log").write_text("")
    with pytest.raises(LogError, match="empty"):
        load_recording(tmp_path)


@pytest.mark.parametrize("shift", [-3600.0, 3600.0, -START])
def test_laps_and_poses_on_another_clock_are_refused(vehicle, tmp_path, shift):
    lap, poses = Lap("cw", START + shift, START + shift + 0.3), recording_of(vehicle).poses
    for file, changes in (
        ("run.toml", {"run": Run("umbmark", 4.0, (lap,))}),
        ("poses.csv", {"poses": replace(poses, time=poses.time + shift)}),
    ):
        save_recording(recording_of(vehicle, **changes), tmp_path / file)
        with pytest.raises(RecordingError, match=rf"{file}: .*clock"):
            load_recording(tmp_path / file)


def test_a_lap_beyond_the_end_of_a_log_is_refused_with_what_to_do(vehicle, tmp_path):
    last = float(recording_of(vehicle).time[-1])
    laps = Lap("cw", START, last), Lap("ccw", last, last + 60.0)
    save_recording(recording_of(vehicle, run=Run("umbmark", 4.0, laps)), tmp_path / "cut")
    with pytest.raises(RecordingError, match=r"lap 2 .* ends early, .* must be left out"):
        load_recording(tmp_path / "cut")


def test_recordings_made_elsewhere_are_whole_and_survive_being_saved(shared_data, tmp_path):
    folders = sorted((shared_data / "concealed").glob("*/*/"))
    assert len(folders) >= 14
    for number, folder in enumerate(folders):
        loaded = read_recording(folder)
        assert loaded.log.blocks.is_whole
        assert loaded.recording.present.all()
        assert loaded.recording.gaps == ()
        counts = count_classes(loaded.log.frames, loaded.recording.vehicle)
        assert {name for name, count in counts.items() if count} <= {"SYNC", "PDO", "heartbeat"}
        if number % 5 == 0:  # one of each kind is enough to write
            save_recording(loaded.recording, tmp_path / str(number))
            assert_equal(load_recording(tmp_path / str(number)), loaded.recording)
