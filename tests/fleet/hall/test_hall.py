import tomllib
from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.fleet.hall.faults import Fault
from omnimate.fleet.hall.hall import draw_hall, hall_lap, write_store
from omnimate.fleet.hall.robots import draw_robot
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose, wrap


@pytest.fixture(scope="module")
def hall():
    return draw_hall(3, 6, faulty=0, places=0)


def heading_errors(recording):
    """Return what each segment from dock to dock turned more than by odometry [rad]."""
    path, poses = dead_reckon(recording), recording.poses
    rows = np.searchsorted(recording.time, poses.time + 1e-6) - 1
    ends = compose(poses.pose[:-1], between(path[rows[:-1]], path[rows[1:]]))
    return wrap(between(ends, poses.pose[1:])[:, 2])


def test_a_lap_is_the_same_whenever_it_is_asked_for_and_no_two_laps_are(hall):
    laps = [hall_lap(hall, hall.robots[0], day, lap, 1.0) for day, lap in ((0, 0), (0, 0), (0, 1), (1, 0))]
    assert np.array_equal(laps[0].poses.pose, laps[1].poses.pose)
    assert len({lap.counts.tobytes() for lap in laps}) == 3


@pytest.mark.parametrize("number", range(3))
def test_every_type_drives_from_dock_to_dock_for_about_the_time_that_is_asked_for(hall, number):
    lap = hall_lap(hall, hall.robots[number], 0, 0, 2.0)
    assert 90.0 < lap.time[-1] - lap.time[0] < 200.0
    distances = np.hypot(*(lap.poses.pose[:, np.newaxis, :2] - hall.docks[:, :2]).transpose(2, 0, 1))
    assert distances.min(axis=1).max() < 1.5  # after 20 m by odometry


def test_poses_are_read_all_along_if_asked_for(hall):
    lap = hall_lap(hall, hall.robots[0], 0, 0, 1.0, pose_period=0.5)
    assert np.diff(lap.poses.time) == pytest.approx(0.495, abs=1e-3)


def test_a_gradual_fault_grows_in_proportion_to_time_and_a_sudden_one_is_there_at_once():
    gradual, sudden = (Fault("wheelbase", "a", day=3, size=0.02, days=days) for days in (4, 0))
    assert [gradual.at(day) for day in range(2, 8)] == pytest.approx([0.0, 0.005, 0.01, 0.015, 0.02, 0.02])
    assert [sudden.at(day) for day in (2, 3)] == [0.0, 0.02]


@pytest.mark.parametrize(
    ("fault", "part"),
    [(Fault("wheelbase", "a", 0, 0.05), "a"), (Fault("wheel_diameter", "a.left", 0, 0.01), "a.left")],
)
def test_a_faulty_robot_turns_otherwise_than_its_odometry_says(hall, fault, part):
    healthy, faulty = draw_robot("tug", 0, 1), draw_robot("tug", 0, 1, faults=(fault,))
    errors = [np.abs(heading_errors(hall_lap(hall, robot, 0, 0, 3.0))).max() for robot in (healthy, faulty)]
    assert errors[1] > 3.0 * errors[0], part


def test_a_joint_bias_shifts_the_reading_of_the_joint(hall):
    healthy, faulty = (
        draw_robot("train", 2, 1, faults=faults)
        for faults in ((), (Fault("joint_bias", "joint_a", 0, 0.02),))
    )
    first = [hall_lap(hall, robot, 0, 0, 1.0).joint_angle("joint_a")[0] for robot in (healthy, faulty)]
    assert first[1] - first[0] == pytest.approx(0.02, abs=2e-3)


@pytest.mark.parametrize("kind", ["wheel_eccentricity", "gear_backlash"])
def test_wheels_out_of_round_and_plays_change_the_drive_but_not_by_much(hall, kind):
    robot = hall.robots[2]
    faulty = replace(robot, faults=(Fault(kind, "a.left", 0, 1e-3),))
    ends = [hall_lap(hall, some, 0, 0, 1.0).poses.pose[1] for some in (robot, faulty)]
    assert 0.0 < np.hypot(*(ends[1] - ends[0])[:2]) < 0.5


def test_a_store_holds_the_recordings_by_robot_and_day_and_the_truth(tmp_path):
    hall = draw_hall(2, 10, faulty=1, places=3, seed=4)
    assert write_store(hall, tmp_path, range(2), 1, 0.5) == 4
    folders = sorted(path.parent for path in tmp_path.glob("robot=*/day=*/*/can.log.gz"))
    assert [str(folder.relative_to(tmp_path)) for folder in folders[:2]] == [
        "robot=mule-0001/day=2026-03-02/060000",
        "robot=mule-0001/day=2026-03-03/060000",
    ]
    with pytest.raises(RecordingError, match="it holds a simulated hall"):
        write_store(hall, tmp_path, range(2), 1, 0.5)
    stored, driven = load_recording(folders[0]), hall_lap(hall, hall.robots[1], 0, 0, 0.5)
    assert np.array_equal(np.diff(stored.counts, axis=0), np.diff(driven.counts, axis=0))
    truth = tomllib.loads((tmp_path / "hall.toml").read_text())
    assert [place["kind"] for place in truth["place"]] == ["joint", "oil", "slope"]
    assert len(truth["sick"]) == 1


def test_more_faulty_robots_than_there_are_and_more_places_than_fit_are_refused():
    with pytest.raises(SimulationError, match="3 faulty robots of 2"):
        draw_hall(2, 5, faulty=3, places=0)
    with pytest.raises(SimulationError, match="do not fit"):
        draw_hall(2, 5, faulty=0, places=9, length=6.0, width=6.0)
