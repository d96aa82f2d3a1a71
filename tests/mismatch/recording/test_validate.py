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
from omnimate.vehicle.recording import Lap, Poses, Run
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


@pytest.mark.parametrize(("seconds", "words"), [(-5.0, "goes back"), (30.0, "jumps")])
def test_a_clock_that_goes_back_or_jumps_is_refused(plain, seconds, words):
    time = plain.time.copy()
    time[1000:] += seconds
    with pytest.raises(RecordingError, match=f"clock {words}"):
        diagnose([replace(plain, time=time)])


def test_two_robots_are_refused(plain):
    other = replace(plain, vehicle=replace(plain.vehicle, name="another"))
    with pytest.raises(RecordingError, match="one robot at a time"):
        diagnose([plain, other])


def test_a_drive_that_is_given_twice_is_refused(plain):
    with pytest.raises(RecordingError, match="copy: holds the same drive"):
        diagnose([plain, replace(plain, source="copy")])


def test_a_missing_channel_is_named_with_its_node(plain):
    present = plain.present.copy()
    present[:, plain.vehicle.channels.index("joint_b")] = False
    with pytest.raises(RecordingError, match=r"joint_b .*node"):
        diagnose([replace(plain, present=present)])


def test_poses_on_another_clock_are_refused(plain):
    poses = Poses(plain.poses.time + 1e6, plain.poses.body, plain.poses.pose, plain.poses.sigma)
    with pytest.raises(RecordingError, match="another clock"):
        diagnose([replace(plain, poses=poses)])


def test_no_recording_is_refused():
    with pytest.raises(RecordingError, match="expected one or more"):
        diagnose([])


def test_a_single_truck_whose_file_of_poses_is_empty_is_insufficient():
    robot = reference_single()
    recording = simulate(robot, Truth(robot), figure_eight(1.0, 1))
    diagnosis = diagnose([replace(recording, poses=recording.poses.select(np.zeros(0, np.int64)))])
    assert (diagnosis.verdict, diagnosis.findings) == ("insufficient", ())
    assert "poses.csv" in diagnosis.says


def test_laps_of_another_drive_are_refused(plain):
    run = Run("free", None, (Lap("none", 1e6, 1e6 + 10.0),))
    with pytest.raises(RecordingError, match=r"lap 0 of run\.toml"):
        diagnose([replace(plain, run=run)])
