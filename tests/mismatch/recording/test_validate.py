"""Recordings that cannot be diagnosed: an error that says what to do, or `insufficient`; never a finding."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.recording import Lap, Run
from tests.mismatch.conftest import cut


@pytest.fixture(scope="module")
def plain(drive):
    return drive(laps=1)


def test_five_seconds_are_insufficient_and_it_says_what_to_record(plain):
    diagnosis = diagnose([cut(plain, slice(0, 330))])
    assert diagnosis.verdict == "insufficient"
    assert not diagnosis.findings
    assert "record" in diagnosis.says


def test_a_robot_that_stands_still_is_insufficient(plain):
    assert diagnose([cut(plain, np.zeros(2000, int))]).verdict == "insufficient"


def late_by(plain, seconds):
    return [replace(plain, time=np.where(np.arange(len(plain)) < 1000, plain.time, plain.time + seconds))]


def without_joint_b(plain):
    is_there = np.array(plain.vehicle.channels) != "joint_b"
    return [replace(plain, present=plain.present & is_there)]


@pytest.mark.parametrize(
    ("recordings", "says"),
    [
        (lambda plain: late_by(plain, -5.0), "clock goes back"),
        (
            lambda plain: [replace(plain, time=plain.time[np.arange(len(plain)) // 2 * 2])],
            r"two samples have the time .* twice in the log",
        ),
        (lambda plain: late_by(plain, 30.0), "clock jumps"),
        (
            lambda plain: [plain, replace(plain, vehicle=replace(plain.vehicle, name="b"))],
            "one robot at a time",
        ),
        (lambda plain: [plain, replace(plain, source="copy")], "copy: holds the same drive"),
        (without_joint_b, r"joint_b .*node"),
        (
            lambda plain: [replace(plain, poses=replace(plain.poses, time=plain.poses.time + 1e6))],
            "another clock",
        ),
        (
            lambda plain: [replace(plain, run=Run("free", None, (Lap("none", 1e6, 1e6 + 10.0),)))],
            r"lap 0 of run\.toml",
        ),
        (lambda _: [], "expected one or more"),
    ],
)
def test_what_cannot_be_diagnosed_is_refused_and_it_says_why(plain, recordings, says):
    with pytest.raises(RecordingError, match=says):
        diagnose(recordings(plain))


def test_a_single_truck_whose_file_of_poses_is_empty_is_insufficient():
    robot = reference_single()
    recording = simulate(robot, Truth(robot), figure_eight(1.0, 1))
    diagnosis = diagnose([replace(recording, poses=recording.poses.select(np.zeros(0, np.int64)))])
    assert (diagnosis.verdict, diagnosis.findings) == ("insufficient", ())
    assert "poses.csv" in diagnosis.says
