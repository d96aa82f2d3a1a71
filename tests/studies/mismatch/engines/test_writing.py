"""Recording folders: the same seed gives the same bytes, and the project reads back what was driven."""

import numpy as np
import pytest

from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.cases import Case, make
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.writing import MEASURING, MOCAP, write

SEED = 21
SHORT = Case("insufficient", (), "squares", "mocap", note="short")


@pytest.fixture(scope="module")
def setting():
    return scene(SHORT, SEED)


@pytest.fixture(scope="module")
def driven(setting):
    return setting.driven([])


def written(folder, setting, driven, measuring=MOCAP, dropped=0.0):
    write(folder, setting.robot, driven, measuring, dropped, np.random.default_rng(4))
    return load_recording(folder)


@pytest.mark.slow
@pytest.mark.parametrize("case", [SHORT, Case("single", (("bump", "a.left"),), "squares", "sonar")])
def test_the_same_seed_gives_the_same_bytes(tmp_path, case):
    labels = [make(tmp_path / name, case, SEED) for name in ("first", "second")]
    assert labels[0] == labels[1]
    files = [
        sorted(path for path in (tmp_path / name).rglob("*") if path.is_file())
        for name in ("first", "second")
    ]
    assert [path.name for path in files[0]] == ["can.log", "poses.csv", "run.toml", "vehicle.toml"]
    assert [path.read_bytes() for path in files[0]] == [path.read_bytes() for path in files[1]]


def test_the_counts_are_read_back(tmp_path, setting, driven):
    recording = written(tmp_path / "1", setting, driven)
    assert len(recording) == len(driven.time)
    assert recording.time == pytest.approx(driven.time, abs=1e-6)
    for column, channel in enumerate(setting.robot.channels):
        steps = np.diff(recording.channel_counts(channel))
        assert np.array_equal(steps, np.diff(driven.counts[:, column])), channel


def test_the_laps_are_read_back(tmp_path, setting, driven):
    laps = written(tmp_path / "1", setting, driven).run.laps
    assert [(lap.direction, lap.start, lap.end) for lap in laps] == [
        (direction, pytest.approx(start, abs=1e-6), pytest.approx(end, abs=1e-6))
        for direction, start, end in driven.laps
    ]


def test_measured_poses_scatter_about_the_true_ones_as_they_state(tmp_path, setting, driven):
    poses = written(tmp_path / "1", setting, driven).poses.of("a")
    true = np.array([np.interp(poses.time, driven.time, driven.poses[:, 0, axis]) for axis in range(3)]).T
    scatter = (poses.pose - true) / np.array(MOCAP.sigma)
    assert np.abs(scatter.mean(axis=0)).max() < 5.0 / np.sqrt(len(scatter))
    assert scatter.std(axis=0) == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * len(scatter)))


def test_without_poses_there_is_no_file_of_them(tmp_path, setting, driven):
    assert written(tmp_path / "1", setting, driven, measuring=MEASURING["none"]).poses is None
    assert not (tmp_path / "1" / "poses.csv").exists()


def test_dropped_frames_are_missing_and_the_rest_is_as_it_was(tmp_path, setting, driven):
    whole = written(tmp_path / "whole", setting, driven)
    holed = written(tmp_path / "holed", setting, driven, dropped=0.05)
    there = holed.present
    assert 0.02 < 1.0 - there.mean() < 0.1
    assert np.array_equal(np.asarray(whole.counts)[there], np.asarray(holed.counts)[there])
