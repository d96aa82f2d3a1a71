from dataclasses import replace

import numpy as np
import pytest

from omnimate.fleet.hall.hall import hall_lap
from omnimate.fleet.segments import cut_segments
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.odometry import truck_travel
from omnimate.vehicle.recording import Gap


def cut(hall, day=0, robot=0, minutes=5.0, pose_period=0.0):
    return cut_segments(hall_lap(hall, hall.robots[robot], day, 0, minutes, pose_period))


def true_parameters(robot, day):
    """Return by how much left and right wheel and wheelbase of truck a differ from the nominal ones."""
    nominal, true = robot.vehicle.trucks["a"], robot.truth_on(day, 0)[0].vehicle.trucks["a"]
    names = ("wheel_diameter_left", "wheel_diameter_right", "wheelbase")
    return np.array([getattr(true, name) / getattr(nominal, name) - 1.0 for name in names])


def test_the_parameters_come_out_within_their_stated_uncertainty_and_the_residuals_are_of_the_size_stated(
    plain_hall,
):
    scaled, chi_square, freedom = [], 0.0, 0
    for day in range(12):
        for robot in plain_hall.robots:
            segments, _ = cut_segments(hall_lap(plain_hall, robot, day, 0, 3.0))
            precision = np.linalg.inv(segments.covariance(CONCRETE_ROUGHNESS))
            jacobian, residual = segments.jacobian.reshape(-1, 3), segments.residual.reshape(-1)
            covariance = np.linalg.inv(jacobian.T @ precision @ jacobian)
            fitted = covariance @ jacobian.T @ precision @ residual
            scaled.append((fitted - true_parameters(robot, day)) / np.sqrt(np.diag(covariance)))
            left = residual - jacobian @ fitted
            chi_square += left @ precision @ left
            freedom += len(residual) - 3
    assert np.std(scaled) == pytest.approx(1.0, abs=0.25)
    assert np.abs(np.mean(scaled, axis=0)).max() < 0.6  # 3.5 standard deviations of the mean of 36
    assert chi_square / freedom == pytest.approx(1.0, abs=0.15)


def test_losing_a_part_of_the_travel_in_every_cell_is_the_same_as_smaller_wheels(plain_hall):
    segments, crossings = cut(plain_hall)
    lost = np.array(
        [crossings.loss[crossings.segment == number].sum(axis=0) for number in range(len(segments))]
    )
    assert lost == pytest.approx(-segments.jacobian[:, :, :2].sum(axis=2), abs=1e-9)


def test_the_travel_over_all_cells_is_the_travel_between_the_first_and_the_last_pose(plain_hall):
    lap = hall_lap(plain_hall, plain_hall.robots[0], 0, 0, 5.0)
    _, crossings = cut_segments(lap)
    middle = 0.5 * sum(truck_travel(lap, "a")[:2])
    ends = np.interp(
        lap.poses.time[[0, -1]], lap.time, np.concatenate([[0.0], np.abs(np.diff(middle)).cumsum()])
    )
    assert crossings.creep.sum() == pytest.approx(ends[1] - ends[0], rel=1e-3)


def test_dense_poses_make_segments_that_share_the_pose_between_them(plain_hall):
    segments, _ = cut(plain_hall, minutes=1.0, pose_period=0.5)
    assert segments.follows[1:].all()
    covariance = segments.covariance(CONCRETE_ROUGHNESS)
    assert np.linalg.eigvalsh(covariance)[0] > 0.0
    assert covariance[0, 3] < 0.0


def test_a_segment_over_which_a_counter_was_lost_is_left_out(plain_hall):
    lap = hall_lap(plain_hall, plain_hall.robots[0], 0, 0, 3.0)
    middle = float(lap.poses.time[1] + 0.5 * (lap.poses.time[2] - lap.poses.time[1]))
    broken = replace(lap, gaps=(Gap("a.left", middle - 0.1, middle, "reboot"),))
    whole, less = cut_segments(lap)[0], cut_segments(broken)[0]
    assert len(less) == len(whole) - 1
    assert not less.follows[1]


def test_a_recording_without_two_poses_gives_nothing(plain_hall):
    lap = hall_lap(plain_hall, plain_hall.robots[0], 0, 0, 1.0)
    assert cut_segments(replace(lap, poses=None)) is None
