"""The linkage tells its own biases and much of the trucks, and what it cannot tell is named."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.linkage.calibration import calibrate_linkage, corrected_linkage
from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.motion.paths import figure_eight, free, out_and_back, umbmark
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import SMOOTH, Floor
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, uncalibrated
from tests.recordings import frozen

ROBOT = reference_vehicle()
TRUE = uncalibrated(ROBOT)
BIASES = {"effects": linkage_biases(0.010, -0.004, 0.002)}
SIZES = ("mean diameter (E_s), both",)  # the scale of all lengths, which the link's bias looks like
BIAS_NAMES = ("joint bias, both", "joint bias, a against b", "link bias")
WHEELBASE, RATIO = 2.0 * np.log(336.17 / 340.0), 2.0 * np.log(1.00084)
TRUTH = np.array([0.0, 0.0, 0.0, WHEELBASE, 0.0, RATIO, 0.003, 0.014, 0.002])


def without_poses(recording):
    """Return a recording by encoders alone: without absolute poses there are no loop closures."""
    return replace(recording, poses=None)


def errors_of(estimate):
    """Return the errors in standard deviations, nan where held."""
    free = estimate.sigma > 0.0
    return np.where(free, (estimate.coordinates - TRUTH) / np.where(free, estimate.sigma, 1.0), np.nan)


@pytest.mark.slow
def test_a_drive_with_turns_tells_all_but_the_size_of_the_wheels():
    """Ten free drives: biases, wheelbases and ratios within their uncertainty; no outside measurement."""
    errors = []
    for seed in range(10):
        recording = simulate(ROBOT, Truth(TRUE, seed=seed, **BIASES), free(seed, 1))
        found = calibrate_linkage([without_poses(recording)])
        assert "mean diameter (E_s), both" in {one.name for one in found.estimate.held}
        errors.append(errors_of(found.estimate))
    told = np.array(errors)[:, [0, 2, 3, 4, 5, 6, 7, 8]]
    assert 0.6 < np.nanstd(told) < 1.2
    assert np.nanmean(np.abs(told) < 1.96) > 0.9


@pytest.fixture(scope="module")
def smooth():
    """A drive with biases on a smooth floor, and its calibration."""
    recording = simulate(ROBOT, Truth(TRUE, floor=SMOOTH, **BIASES), figure_eight(1.0, 3))
    return recording, calibrate_linkage([without_poses(recording)], hold=SIZES)


def test_on_a_smooth_floor_the_biases_come_out_to_a_fraction_of_a_count(smooth):
    _, found = smooth
    count = 2.0 * np.pi / 2**14
    np.testing.assert_allclose(found.joint_bias, [0.010, -0.004], atol=count)
    assert found.link_bias == pytest.approx(0.002, abs=3e-4)


def test_a_straight_drive_does_not_tell_the_joints_from_the_ratios():
    """C 5.2: joints that differ in bias and wheels that differ in size bend a straight drive alike."""
    recording = simulate(ROBOT, Truth(TRUE, seed=1, **BIASES), out_and_back(10.0, 1, link_length=1.0))
    found = calibrate_linkage([without_poses(recording)])
    held = {one.name: one.reason for one in found.estimate.held}
    both = "combination of diameter ratio (E_d), both and joint bias, a against b"
    assert both in held["diameter ratio (E_d), both"]
    assert both in held["joint bias, a against b"]
    assert {"wheelbase, both", "mean diameter (E_s), both", "link bias"} <= held.keys()


def test_known_trucks_and_loop_closures_make_the_biases_more_certain():
    recording = simulate(ROBOT, Truth(TRUE, seed=2, **BIASES), umbmark(4.0, 1, link_length=1.0))
    alone = calibrate_linkage([without_poses(recording)])
    closed = calibrate_linkage([recording])
    trucks = {name: calibrate_truck([recording], name) for name in ROBOT.trucks}
    known = calibrate_linkage([recording], trucks=trucks)
    for better in (closed, known):
        assert better.estimate.sigma[8] < alone.estimate.sigma[8] or alone.estimate.sigma[8] == 0.0
    free = known.estimate.sigma[6:] > 0.0
    away = (known.estimate.coordinates[6:] - TRUTH[6:])[free] / known.estimate.sigma[6:][free]
    assert np.abs(away).max() < 4.0


def test_the_linkage_alone_calibrates_the_wheels_on_a_smooth_floor():
    """C 5.1, with biases known to be 0: the ratios and wheelbases of both trucks."""
    recording = simulate(ROBOT, Truth(TRUE, floor=Floor(roughness=5e-5), seed=3), free(1, 2))
    found = calibrate_linkage(
        [without_poses(recording)], hold=("joint bias, both", "joint bias, a against b", "link bias")
    )
    assert found.joint_bias == (0.0, 0.0)
    for name, truck in found.trucks.items():
        ratio = truck.wheel_diameter_right / truck.wheel_diameter_left
        true = TRUE.trucks[name]
        assert ratio == pytest.approx(true.wheel_diameter_right / true.wheel_diameter_left, abs=1e-4)
        assert truck.wheelbase == pytest.approx(true.wheelbase, rel=1e-3)


def test_the_corrected_robot_reads_its_linkage_without_bias(smooth):
    recording, calibration = smooth
    corrected = corrected_linkage(ROBOT, calibration)
    again = replace(recording, vehicle=corrected)
    count = 2.0 * np.pi / 2**14
    for joint, bias in (("joint_a", 0.010), ("joint_b", -0.004)):
        taken = recording.joint_angle(joint) - again.joint_angle(joint)
        np.testing.assert_allclose(taken, bias, atol=1.5 * count)
    np.testing.assert_allclose(recording.link_length() - again.link_length(), 0.002, atol=3e-4)


@pytest.mark.parametrize("channel", ["joint_a", "joint_b", "link", "b.left"])
def test_a_frozen_channel_is_named(channel):
    recording = simulate(ROBOT, Truth(TRUE, seed=1), figure_eight(1.0, 1))
    with pytest.raises(CalibrationError, match=f"{channel} is frozen"):
        calibrate_linkage([frozen(recording, channel)])


def test_a_single_truck_has_no_linkage():
    single = reference_single()
    recording = simulate(single, Truth(single), figure_eight(1.0, 1))
    with pytest.raises(CalibrationError, match="no linkage"):
        calibrate_linkage([recording])
