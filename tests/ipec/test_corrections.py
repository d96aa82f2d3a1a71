"""The equations: the CLAPPER's, C (9)-(16), with its systematic errors, C 5.2; the OmniMate's; tolerances."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.crossing import cable_loss
from omnimate.ipec.corrections import excess_over_tolerance
from omnimate.ipec.corrector import correct
from omnimate.motion.paths import out_and_back, rounded_rectangle
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import SMOOTH, Floor, bumps_under
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.sonar import Sonar

EXACT = Sonar(sigma=0.0)


def straight(robot, bumps=(), length=6.0, **truth):
    truth = Truth(robot, floor=Floor(0.0, bumps), sonar=EXACT, **truth)
    return simulate(robot, truth, out_and_back(length, 1, link_length=1.0))


def outward(recording):
    """Return the samples of the way out."""
    travel = recording.wheel_angle("a.left")
    return slice(0, int(np.argmax(travel)) + 1)


def test_joint_offsets_of_one_degree_bend_a_straight_drive_to_a_radius_of_28_6_m(robot):
    """NOTES on C 5.2: the drift is (delta_A - delta_B) / l per metre."""
    recording = straight(robot, effects=linkage_biases(np.radians(1.0), np.radians(-1.0)))
    way = outward(recording)
    path = correct(recording).pose_a[way]
    driven = np.hypot(*np.diff(path[:, :2], axis=0).T).sum()
    assert driven / abs(path[-1, 2] - path[0, 2]) == pytest.approx(28.6, abs=0.5)


@pytest.mark.parametrize("direction", ["cw", "ccw"])
def test_a_millimetre_of_link_bias_costs_a_third_of_a_degree_per_turn(fine, lap_errors, direction):
    """NOTES on C 5.2: 0.34 to 0.36 degrees per 360 degree turn, beside the error without the bias."""
    program = rounded_rectangle(6.0, 3.25, [direction])
    errors = []
    for bias in (0.0, 0.001):
        truth = Truth(fine, effects=linkage_biases(link=bias), floor=SMOOTH, sonar=EXACT)
        recording = simulate(fine, truth, program)
        errors.append(np.degrees(lap_errors(recording, correct(recording).pose_a)[0, 2]))
    assert 0.33 < abs(errors[1] - errors[0]) < 0.37


@pytest.mark.parametrize("wheel", ["a.left", "a.right"])
@pytest.mark.parametrize("way", ["out", "back"])
def test_the_lost_travel_is_taken_back_on_either_side_and_in_either_direction(fine, lap_errors, wheel, way):
    """C (14)-(15) with |delta| and the direction of travel: half of what ten bumps cost, to 10 %."""
    begin = 0.5 if way == "out" else 6.5
    recording = straight(fine, bumps_under(wheel, 10, begin, begin + 5.0))
    path = correct(recording)
    lost = 10 * 0.5 * cable_loss(0.075, 0.010)
    assert abs(path.taken_back.sum()) == pytest.approx(lost, rel=0.1)
    without = correct(recording, method="omnimate")
    error, uncorrected = (lap_errors(recording, trajectory.pose_a)[0, 0] for trajectory in (path, without))
    assert abs(uncorrected) == pytest.approx(lost, rel=0.1)
    assert abs(error) < 0.1 * lost


def test_joints_of_a_third_of_a_degree_do_not_make_a_drive_drift(coarse, lap_errors):
    """A reading that stands still within its step corrects nothing: below 0.2 degrees and 3 mm."""
    truth = Truth(coarse, floor=SMOOTH, sonar=EXACT)
    for program in (out_and_back(9.0, 1, link_length=1.0), rounded_rectangle(6.0, 3.25, ["cw", "ccw"])):
        recording = simulate(coarse, truth, program)
        aware = lap_errors(recording, correct(recording).pose_a)
        assert np.degrees(np.abs(aware[:, 2])).max() < 0.2
        assert np.hypot(*aware[:, :2].T).max() < 0.02


def test_unequal_wheels_are_corrected_as_they_turn_the_trucks(robot, lap_errors):
    """C 5.1: a diameter ratio of 1.005 turns plain odometry by 15 degrees in 18 m, IPEC by below 0.5."""
    truck = replace(robot.trucks["a"], wheel_diameter_left=0.14963, wheel_diameter_right=0.15037)
    truth = Truth(robot.with_truck("a", truck), floor=SMOOTH, sonar=EXACT)
    recording = simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["cw"]))
    plain, path = correct(recording, method="plain"), correct(recording)
    assert abs(np.degrees(lap_errors(recording, plain.pose_a)[0, 2])) > 10.0
    assert abs(np.degrees(lap_errors(recording, path.pose_a)[0, 2])) < 0.5


def test_omnimate_as_corrected_stays_below_a_hundredth_of_a_degree_in_a_turn(robot, lap_errors):
    """O (1)-(6) in a car-like turn of 360 degrees; `studies.papers` has what the print does."""
    truth = Truth(robot, floor=SMOOTH, sonar=EXACT)
    turns = simulate(robot, truth, rounded_rectangle(6.0, 3.25, ["cw", "ccw"]))
    errors = lap_errors(turns, correct(turns, method="omnimate").pose_a)
    assert np.degrees(np.abs(errors[:, 2])).max() < 0.01


@given(st.floats(-10.0, 10.0), st.floats(0.0, 5.0))
def test_within_the_tolerance_nothing_is_left_and_outside_the_distance_to_it(error, tolerance):
    expected = max(abs(error) - tolerance, 0.0)
    assert abs(excess_over_tolerance(error, tolerance)) == pytest.approx(expected, abs=1e-12)
    assert excess_over_tolerance(error, tolerance) * error >= 0.0
    assert excess_over_tolerance(-error, tolerance) == -excess_over_tolerance(error, tolerance)
    assert excess_over_tolerance(error, 0.0) == error
