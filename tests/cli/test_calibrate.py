"""`omnimate calibrate` and `omnimate design`: what they print and write."""

import re
import shutil

import numpy as np
import pytest

from omnimate.calib.relative.motions import COLUMNS
from omnimate.files.recordings.folder import load_recording
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.file import load_vehicle
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose


@pytest.fixture
def without_poses(erring_drive, tmp_path):
    return shutil.copytree(erring_drive, tmp_path / "without", ignore=shutil.ignore_patterns("poses.csv"))


def test_both_trucks_are_calibrated_and_written(accepted, erring_drive, tmp_path):
    result = accepted(
        "calibrate", erring_drive, "--out", tmp_path / "new.toml", "--plot", tmp_path / "way.svg"
    )
    assert "Truck a" in result.out
    assert "Truck b" in result.out
    assert "held: these drives identify it" in result.out
    assert re.search(r"roughness 0\.000\d+ m/sqrt\(m\) \(estimated", result.out)
    trucks = load_vehicle(tmp_path / "new.toml").trucks
    assert trucks["a"].wheelbase == pytest.approx(0.33617, abs=1e-3)
    assert trucks["b"].wheelbase == pytest.approx(0.34387, abs=1e-3)
    labels = re.findall(r"<!-- (truck .*) -->", (tmp_path / "way.svg").read_text())
    assert labels == [f"truck {name}, {what}" for name in "ab" for what in ("odometry before", "calibrated")]


def test_one_truck_may_be_chosen(omnimate, erring_drive):
    result = omnimate("calibrate", erring_drive, "--truck", "b")
    assert "Truck b" in result.out
    assert "Truck a" not in result.out


def test_the_linkage_is_calibrated_and_its_zeros_are_written(omnimate, erring_drive, tmp_path):
    result = omnimate("calibrate", erring_drive, "--linkage", "--out", tmp_path / "new.toml")
    assert "joint_a bias" in result.out
    before, after = reference_vehicle(), load_vehicle(tmp_path / "new.toml")
    shift = (after.encoder("joint_a").zero - before.encoder("joint_a").zero) * before.encoder("joint_a").scale
    assert shift == pytest.approx(0.010, abs=2e-3)


def test_a_plot_of_a_linkage_alone_is_refused(refused, without_poses, tmp_path):
    assert "no truck has two absolute poses" in refused(
        "calibrate", without_poses, "--linkage", "--plot", tmp_path / "way.svg"
    )


def test_relative_poses_calibrate_a_truck_and_place_their_sensor(accepted, erring_drive, tmp_path):
    """The sensor's motions are those of the odometry, so that the truck stays and its sensor is found."""
    recording = load_recording(erring_drive)
    every = slice(0, None, 50)
    seen = compose(dead_reckon(recording), [0.25, -0.1, 0.5])[every]
    time = recording.time[every]
    motions = np.column_stack([time[:-1], time[1:], between(seen[:-1], seen[1:])])
    lines = [",".join(map(repr, map(float, row))) + ",0.003,0.003,0.002" for row in motions]
    path, out = tmp_path / "relative.csv", tmp_path / "vehicle.toml"
    path.write_text("\n".join([",".join(COLUMNS), *lines]))
    result = accepted("calibrate", erring_drive, "--relative", path, "--out", out)
    assert re.search(r"sensor x .* 250\.\d+ ", result.out)
    assert re.search(r"sensor yaw .* 28\.64", result.out)
    assert load_vehicle(out).trucks["a"].wheelbase == pytest.approx(0.34, abs=1e-4)


def test_poses_that_are_missing_are_an_error_of_one_sentence(omnimate, without_poses):
    assert "poses.csv has no pose of truck a" in omnimate("calibrate", without_poses).err


def test_designs_are_compared(omnimate, accepted, tmp_path):
    result = accepted("design", "--length", 14, "--width", 4, "--metres", 160, "--heading")
    assert re.search(r"open straights of 14 m plus counted spins .* 8\.\d", result.out)
    assert re.search(r"one direction .* not known", result.out)
    assert "--heading" in omnimate("design").out
