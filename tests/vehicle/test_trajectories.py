"""Odometry over a recording, beside the absolute poses."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import wrap
from omnimate.vehicle.trajectories import format_trajectories, trajectories


@pytest.fixture(scope="module")
def recording():
    robot = reference_vehicle()
    return simulate(robot, Truth(robot, seed=1), umbmark(0.5, 1, speed=0.4, link_length=1.0))


def test_each_truck_goes_from_its_first_pose_and_is_held_against_its_last(recording):
    for path in trajectories(recording):
        fixes = recording.poses.of(path.truck).pose
        assert np.array_equal(path.pose, dead_reckon(recording, path.truck, fixes[0]))
        assert np.array_equal(path.fix, fixes[-1])
        assert np.hypot(*path.error[:2]) < 0.2
        assert abs(path.error[2]) <= np.pi
        assert path.length > 4 * 0.5


def test_a_first_pose_in_mid_drive_is_on_the_trajectory(recording):
    row = len(recording) // 2
    time = recording.time[[row, -1]]
    poses = replace(recording.poses, time=np.repeat(time, 2), body=np.array(["a", "b", "a", "b"]),
                    pose=np.arange(12.0).reshape(4, 3) / 10.0, sigma=np.full((4, 3), np.nan))  # fmt: skip
    for number, path in enumerate(trajectories(replace(recording, poses=poses))):
        away = path.pose[row] - poses.pose[number]
        assert [*away[:2], wrap(away[2])] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
        assert abs(path.pose[0, 2]) <= np.pi


def test_without_poses_odometry_begins_at_zero_and_nothing_is_held_against_it(recording):
    for path in trajectories(replace(recording, poses=None)):
        assert path.pose[0].tolist() == [0.0, 0.0, 0.0]
        assert path.fix is None
        assert path.error is None


def test_the_table_has_a_line_for_each_sample_of_each_truck(recording):
    lines = format_trajectories(trajectories(recording)).splitlines()
    assert lines[0] == "t,body,x,y,theta"
    assert len(lines) == 1 + 2 * len(recording)
    assert [line.split(",")[1] for line in (lines[1], lines[-1])] == ["a", "b"]
