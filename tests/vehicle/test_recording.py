"""Recordings: frozen, consistent, and in the units that they state."""

import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import parse_vehicle
from omnimate.vehicle.recording import Poses, Recording


@pytest.fixture
def recording(robot_toml):
    vehicle = parse_vehicle(robot_toml)
    counts = np.zeros((4, 7), np.int64)
    counts[:, 0] = [0, 10_000, 20_000, 40_000]
    counts[:, 4] = [12_288, 16_384, 16_384 + 4096, 16_384 + 8192]
    counts[:, 6] = [0, 10, -10, 0]
    return Recording(vehicle, np.arange(4) * 0.015, counts, np.ones((4, 7), bool))


def test_channels_come_in_radians_and_metres(recording):
    assert np.allclose(recording.wheel_angle("a.left"), [0, math.pi / 2, math.pi, 2 * math.pi])
    assert np.allclose(recording.link_length(), [1.0, 1.001, 0.999, 1.0])


def test_a_joint_begins_within_half_a_turn_and_goes_on_without_a_jump(recording):
    quarter = math.pi / 2
    assert np.allclose(recording.joint_angle("joint_a"), [-quarter, 0, quarter, 2 * quarter])


@pytest.mark.parametrize("read", ["is_present", "channel_counts", "wheel_angle", "joint_angle"])
def test_a_channel_that_the_robot_does_not_have_is_named_with_those_that_it_has(recording, read):
    with pytest.raises(RecordingError, match=r"no channel c.left; the robot has a.left, a.right"):
        getattr(recording, read)("c.left")


def test_nothing_in_it_can_be_overwritten(recording):
    with pytest.raises(ValueError, match="read-only"):
        recording.counts[0, 0] = 1
    with pytest.raises(AttributeError):
        recording.source = "elsewhere"


def test_times_must_be_finite(recording):
    with pytest.raises(ValueError, match="expected seconds, one for each SYNC"):
        replace(recording, time=np.where(recording.time > recording.time[1], np.nan, recording.time))


def test_shapes_must_belong_together(recording):
    with pytest.raises(ValueError, match="expected"):
        Recording(recording.vehicle, recording.time, np.zeros((4, 6), np.int64), np.ones((4, 7), bool))
    with pytest.raises(ValueError, match="do not belong"):
        Poses(np.zeros(2), np.array(["a"]), np.zeros((1, 3)), np.zeros((1, 3)))


def test_an_empty_recording_says_what_it_expected(robot_toml):
    with pytest.raises(RecordingError, match="SYNC"):
        Recording(parse_vehicle(robot_toml), np.zeros(0), np.zeros((0, 7), np.int64), np.zeros((0, 7), bool))


def test_between_takes_both_ends_in(recording):
    assert recording.between(0.015, 0.030) == slice(1, 3)


def test_a_standard_deviation_of_zero_is_unknown():
    poses = Poses(np.zeros(1), np.array(["a"]), np.zeros((1, 3)), np.array([[0.0, 0.002, 0.0]]))
    assert np.isnan(poses.sigma).tolist() == [[True, False, True]]
