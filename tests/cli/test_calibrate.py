"""`omnimate calibrate` and `omnimate design`: what they print and write."""

import re
import shutil

import numpy as np
import pytest

from omnimate.calib.relative.motions import COLUMNS
from omnimate.files.recordings.folder import load_recording, save_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.file import load_vehicle
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    robot = reference_vehicle()
    true = with_errors(robot, {"a": 336.17 / 340.0, "b": 340.0 / 336.17}, {"a": 1.00084, "b": 1.0 / 1.00084})
    path = tmp_path_factory.mktemp("drive") / "recording"
    truth = Truth(true, effects=linkage_biases(0.01, -0.004, 0.002), seed=1)
    save_recording(simulate(robot, truth, umbmark(4.0, 2, link_length=1.0)), path)
    return path


def test_both_trucks_are_calibrated_and_written(omnimate, folder, tmp_path):
    result = omnimate("calibrate", folder, "--out", tmp_path / "new.toml", "--plot", tmp_path / "way.svg")
    assert result.code == 0
    assert "Truck a" in result.out
    assert "Truck b" in result.out
    assert "held: these drives identify it" in result.out
    assert re.search(r"roughness 0\.000\d+ m/sqrt\(m\) \(estimated", result.out)
    trucks = load_vehicle(tmp_path / "new.toml").trucks
    assert trucks["a"].wheelbase == pytest.approx(0.33617, abs=1e-3)
    assert trucks["b"].wheelbase == pytest.approx(0.34387, abs=1e-3)
    labels = re.findall(r"<!-- (truck .*) -->", (tmp_path / "way.svg").read_text())
    assert labels == [f"truck {name}, {what}" for name in "ab" for what in ("odometry before", "calibrated")]


def test_one_truck_may_be_chosen(omnimate, folder):
    result = omnimate("calibrate", folder, "--truck", "b")
    assert "Truck b" in result.out
    assert "Truck a" not in result.out


def test_the_linkage_is_calibrated_and_its_zeros_are_written(omnimate, folder, tmp_path):
    result = omnimate("calibrate", folder, "--linkage", "--out", tmp_path / "new.toml")
    assert "joint_a bias" in result.out
    before, after = reference_vehicle(), load_vehicle(tmp_path / "new.toml")
    shift = (after.encoder("joint_a").zero - before.encoder("joint_a").zero) * before.encoder("joint_a").scale
    assert shift == pytest.approx(0.010, abs=2e-3)


def test_a_plot_of_a_linkage_alone_is_refused(refused, folder, tmp_path):
    without = shutil.copytree(folder, tmp_path / "without")
    (without / "poses.csv").unlink()
    assert "no truck has two absolute poses" in refused(
        "calibrate", without, "--linkage", "--plot", tmp_path / "way.svg"
    )


def test_relative_poses_calibrate_a_truck_and_place_their_sensor(omnimate, folder, tmp_path):
    """The sensor's motions are those of the odometry, so that the truck stays and its sensor is found."""
    recording = load_recording(folder)
    every = slice(0, None, 50)
    seen = compose(dead_reckon(recording), [0.25, -0.1, 0.5])[every]
    time = recording.time[every]
    motions = np.column_stack([time[:-1], time[1:], between(seen[:-1], seen[1:])])
    lines = [",".join(map(repr, map(float, row))) + ",0.003,0.003,0.002" for row in motions]
    path, out = tmp_path / "relative.csv", tmp_path / "vehicle.toml"
    path.write_text("\n".join([",".join(COLUMNS), *lines]))
    result = omnimate("calibrate", folder, "--relative", path, "--out", out)
    assert result.code == 0
    assert re.search(r"sensor x .* 250\.\d+ ", result.out)
    assert re.search(r"sensor yaw .* 28\.64", result.out)
    assert load_vehicle(out).trucks["a"].wheelbase == pytest.approx(0.34, abs=1e-4)


def test_poses_that_are_missing_are_an_error_of_one_sentence(omnimate, folder, tmp_path):
    for file in folder.iterdir():
        if file.name != "poses.csv":
            (tmp_path / file.name).write_bytes(file.read_bytes())
    assert "poses.csv has no pose of truck a" in omnimate("calibrate", tmp_path).err


def test_designs_are_compared(omnimate, tmp_path):
    result = omnimate("design", "--length", 14, "--width", 4, "--metres", 160, "--heading")
    assert result.code == 0
    assert re.search(r"open straights of 14 m plus counted spins .* 8\.\d", result.out)
    assert re.search(r"one direction .* not known", result.out)
    assert "--heading" in omnimate("design").out
