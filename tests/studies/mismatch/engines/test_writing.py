"""Robots and recording folders: the project reads back what is described, and what was driven."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.file import parse_vehicle
from studies.mismatch.engines.scene import Case, make, scene
from studies.mismatch.engines.vocabulary import LINKAGE, WHEELS
from studies.mismatch.engines.writing import MOCAP, random_robot, toml_of, write

SEED = 21
SHORT = Case("insufficient", (), "squares", "mocap", note="short")


@given(st.integers(0, 2**32), st.sampled_from([1, 2]))
def test_the_project_reads_a_robot_as_it_is(seed, trucks):
    robot = random_robot(np.random.default_rng(seed), trucks)
    assert robot == random_robot(np.random.default_rng(seed), trucks)
    assert robot.channels == (WHEELS + LINKAGE if trucks == 2 else WHEELS[:2])
    assert len({device.node for device in robot.devices}) == len(robot.devices)
    vehicle = parse_vehicle(toml_of(robot))
    assert vehicle.name == robot.name
    assert [truck.wheelbase for truck in vehicle.trucks.values()] == list(robot.wheelbase)
    sizes = [0.5 * vehicle.wheel_diameter(wheel) for wheel in vehicle.wheels]
    assert sizes == pytest.approx(list(robot.radius))
    assert vehicle.bus.sync_period == robot.period
    assert (vehicle.linkage is None) == (trucks == 1)
    names = ("channel", "node", "cob_id", "start_bit", "bits", "signed", "sign", "zero")
    for encoder, device in zip(vehicle.encoders, robot.devices, strict=True):
        assert [getattr(encoder, name) for name in names] == [getattr(device, name) for name in names]


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
def test_the_same_seed_gives_the_same_bytes(written_twice, case):
    _, folder = written_twice(make, case, SEED)
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["can.log", "poses.csv", "run.toml", "vehicle.toml"]


def test_counts_and_laps_are_read_back(tmp_path, setting, driven):
    recording = written(tmp_path / "1", setting, driven)
    assert recording.time == pytest.approx(driven.time, abs=1e-6)
    for column, channel in enumerate(setting.robot.channels):
        steps = np.diff(recording.channel_counts(channel))
        assert np.array_equal(steps, np.diff(driven.counts[:, column])), channel
    assert [(lap.direction, lap.start, lap.end) for lap in recording.run.laps] == [
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
    assert written(tmp_path / "1", setting, driven, measuring=None).poses is None
    assert not (tmp_path / "1" / "poses.csv").exists()


def test_dropped_frames_are_missing_and_the_rest_is_as_it_was(tmp_path, setting, driven):
    whole = written(tmp_path / "whole", setting, driven)
    holed = written(tmp_path / "holed", setting, driven, dropped=0.05)
    there = holed.present
    assert 0.02 < 1.0 - there.mean() < 0.1
    assert np.array_equal(np.asarray(whole.counts)[there], np.asarray(holed.counts)[there])
