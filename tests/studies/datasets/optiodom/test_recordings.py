"""The OptiOdom data come out as recordings that say what the data say."""

import numpy as np
import pytest

from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.reference import dead_reckoned
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import between, compose
from studies.datasets.optiodom.drives import each_recording, read_set
from studies.datasets.optiodom.scores import read_squares, score

SQUARE = "real/optiodom/diff/square/230620202042"


@pytest.fixture(scope="module")
def runs(shared_data):
    return dict(each_recording(shared_data / "real/optiodom"))


def test_every_run_of_the_differential_robot_becomes_a_recording_without_gaps(runs):
    assert len(runs) == 103
    assert all(recording.present.all() and not recording.gaps for recording in runs.values())
    assert all(len(recording.poses.time) == len(recording) for recording in runs.values())


def test_the_odometry_of_a_recording_is_that_of_the_calibrations_own_reader(runs, shared_data):
    data = read_set(shared_data / SQUARE)
    for number, drive in enumerate(data.drives, start=1):
        recording = runs[f"diff/square/230620202042/run-{number:02}"]
        path = dead_reckon(recording)
        away = compose(drive.pose[0], between(path[0], path)) - dead_reckoned(drive, data.kinematics)
        assert np.abs(away[:, :2]).max() < 1e-9
    assert isinstance(data.kinematics, Differential)
    assert score(data, data.kinematics).final == pytest.approx(0.0234, abs=1e-4)


def test_squares_keep_their_side_and_the_direction_that_their_wheels_turn(runs, shared_data):
    expected = read_squares(shared_data / SQUARE)
    for number, square in enumerate(expected.runs, start=1):
        run = runs[f"diff/square/230620202042/run-{number:02}"].run
        assert (run.protocol, run.side) == ("umbmark", expected.side)
        assert [lap.direction for lap in run.laps] == [square.direction]
