"""The public interface: `import omnimate` is light, and its functions do what the rooms behind them do."""

import subprocess
import sys

import numpy as np
import pytest

import omnimate
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.truth import Truth, uncalibrated


def test_importing_the_package_loads_no_library():
    words = "import omnimate, sys; print({'numpy', 'scipy', 'numba', 'can', 'canopen'} & set(sys.modules))"
    shown = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "set()"


@pytest.mark.parametrize("name", omnimate.__all__)
def test_every_public_name_is_there_and_documented(name):
    assert getattr(omnimate, name).__doc__
    assert name in dir(omnimate)


def test_a_name_that_is_not_public_is_refused_with_those_that_are():
    with pytest.raises(AttributeError, match=r"it has Calibrated, .* track"):
        omnimate.umbmark  # noqa: B018


def test_calibrating_a_simulated_drive_of_a_smooth_floor_gives_the_true_wheelbases_back():
    vehicle = reference_vehicle()
    truth = Truth(uncalibrated(vehicle), floor=SMOOTH)
    recording = omnimate.simulate(vehicle, umbmark(2.0, 1, link_length=vehicle.linkage.length), truth=truth)
    calibrated = omnimate.calibrate([recording])
    for name, truck in calibrated.trucks.items():
        low, high = next((q.low, q.high) for q in truck.quantities if q.name == "wheelbase")
        assert low <= truth.vehicle.trucks[name].wheelbase <= high
    assert calibrated.vehicle.trucks["a"].wheelbase != vehicle.trucks["a"].wheelbase


def test_tracking_gives_a_pose_for_every_sample():
    recording = omnimate.simulate()
    estimate = omnimate.track(recording)
    assert estimate.pose_a.shape == (len(recording), 3)
    assert np.isfinite(estimate.pose_a).all()


def test_a_recording_survives_its_folder(tmp_path):
    recording = omnimate.simulate()
    omnimate.save_recording(recording, tmp_path / "drive")
    assert np.array_equal(omnimate.load_recording(tmp_path / "drive").counts, recording.counts)


def test_a_log_whose_clock_goes_back_or_that_has_other_lines_is_loaded_with_warnings(tmp_path):
    omnimate.save_recording(omnimate.simulate(), tmp_path)
    lines = (tmp_path / "can.log").read_text().splitlines()
    half = len(lines) // 2
    swapped = ["no frame", *lines[half:], *lines[:half]]
    (tmp_path / "can.log").write_text("\n".join(swapped) + "\n")
    with pytest.warns(UserWarning, match="can.log") as caught:
        recording = omnimate.load_recording(tmp_path)
    assert recording.time[0] > recording.time[-1]
    first, second = (str(warning.message) for warning in caught)
    assert "the clock goes back 1 times" in first
    assert "can.log:1: skipped" in second


@pytest.mark.parametrize("name", ["missing/vehicle.toml", "."])
def test_a_vehicle_that_cannot_be_written_is_an_error_that_names_the_file(tmp_path, name):
    with pytest.raises(omnimate.OmnimateError, match="cannot be written"):
        omnimate.save_vehicle(reference_vehicle(), tmp_path / name)


def test_calibrating_nothing_is_refused_with_what_is_expected():
    with pytest.raises(omnimate.OmnimateError, match="expected one or more"):
        omnimate.calibrate([])


@pytest.mark.slow
def test_a_driver_on_a_bus_without_nodes_says_which_node_is_missing_and_closes_the_bus():
    with pytest.raises(omnimate.OmnimateError, match="node 1"):
        omnimate.open_driver(reference_vehicle(), "virtual://empty")
