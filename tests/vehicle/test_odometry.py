"""Dead reckoning: whole recordings and single samples agree, and lost samples never look like a turn."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import parse_vehicle
from omnimate.vehicle.odometry import Odometer, check_pose_units, dead_reckon
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import compose, wrap
from tests.recordings import samples


def recording_of(vehicle, left, right, present=None):
    counts = np.zeros((len(left), len(vehicle.channels)), np.int64)
    counts[:, 0], counts[:, 1] = left, right
    if present is None:
        present = np.ones(counts.shape, bool)
    time = vehicle.bus.sync_period * np.arange(len(left), dtype=np.float64)
    return Recording(vehicle, time, counts, present)


@pytest.fixture(scope="module")
def vehicle():
    same = "start_bit = 0, bits = 32, signed = true"
    text = f"""
    truck.a = {{wheelbase = 0.34, wheel_diameter_left = 0.15, wheel_diameter_right = 0.1502}}
    bus = {{bitrate = 500000, sync_period = 0.015}}
    encoder = [
      {{channel = "a.left", node = 1, cob_id = 0x181, {same}, sign = 1, counts_per_turn = 40000}},
      {{channel = "a.right", node = 2, cob_id = 0x182, {same}, sign = -1, counts_per_turn = 4096.5}},
    ]
    """
    return parse_vehicle(text)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_whole_recording_and_sample_by_sample_agree_to_1e_12(vehicle, seed):
    random = np.random.default_rng(seed)
    wheels = np.cumsum(random.integers(-300, 400, (2, 3000)), axis=1)
    present = np.ones((3000, 2), bool)
    present[random.integers(0, 3000, 200), random.integers(0, 2, 200)] = False
    recording = recording_of(vehicle, *wheels, present)
    whole = dead_reckon(recording, "a", (0.3, -0.2, 0.1))
    odometer = Odometer(vehicle, "a", (0.3, -0.2, 0.1))
    stepwise = np.array([odometer.step(sample) for sample in samples(recording)])
    assert np.abs(whole - stepwise).max() < 1e-12


def test_lost_samples_of_one_wheel_leave_the_path_where_it_was(vehicle):
    left, right = 100 * np.arange(200), -10 * np.arange(200)
    present = np.ones((200, 2), bool)
    present[50:120, 0] = False
    complete = dead_reckon(recording_of(vehicle, left, right), "a")
    pierced = dead_reckon(recording_of(vehicle, left, right, present), "a")
    assert np.allclose(pierced[120:], complete[120:], atol=1e-9)
    assert np.allclose(pierced[50:120], pierced[49])


def test_wheels_never_seen_together_are_an_error_that_says_where_to_look(vehicle):
    present = np.array([[True, False], [False, True]])
    with pytest.raises(RecordingError, match=r"a\.left and a\.right are never there in the same sample"):
        dead_reckon(recording_of(vehicle, [0, 1], [0, 1], present), "a")


def driven(vehicle, random, count, frame, *, wrapped):
    """A drive of about 40 m with turns, and `count` poses of it in another frame, with some noise."""
    speeds = random.integers(0, [[900], [92]], (2, 16)).repeat(250, axis=1)
    recording = recording_of(vehicle, *np.cumsum(speeds * [[1], [-1]], axis=1))
    rows = np.sort(random.choice(4000, count, replace=False))
    pose = compose(frame, dead_reckon(recording)[rows]) + random.normal(0.0, 0.01, (count, 3))
    pose[:, 2] = wrap(pose[:, 2]) if wrapped else pose[:, 2]
    sigma = np.full((count, 3), 0.01)
    return replace(recording, poses=Poses(recording.time[rows], np.full(count, "a"), pose, sigma))


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.sampled_from([0, 1, 10, 400]),
    frame=st.tuples(*[st.floats(-50.0, 50.0)] * 3),
    wrapped=st.booleans(),
)
def test_poses_in_metres_and_radians_are_taken_in_any_frame_and_those_in_other_units_refused(
    vehicle, seed, count, frame, wrapped
):
    recording = driven(vehicle, np.random.default_rng(seed), count, frame, wrapped=wrapped)
    check_pose_units(recording, "a")
    for factors, words in (
        ((1e3, 1e3, 1.0), "not in millimetres"),
        ((1.0, 1.0, 180.0 / np.pi), "in radians"),
    ):
        wrong = replace(recording.poses, pose=recording.poses.pose * factors)
        if count >= 10:
            with pytest.raises(RecordingError, match=words):
                check_pose_units(replace(recording, poses=wrong), "a")


def test_poses_of_a_truck_are_taken_where_the_other_truck_was_not_read(robot_toml):
    both = parse_vehicle(robot_toml)
    counts = 100 * np.arange(400)[:, None] * np.ones(len(both.channels), np.int64)
    present = np.ones(counts.shape, bool)
    present[:, both.channels.index("b.left")] = False
    time = both.bus.sync_period * np.arange(400, dtype=np.float64)
    recording = Recording(both, time, counts.astype(np.int64), present)
    pose = dead_reckon(recording, "a")[::50]
    poses = Poses(time[::50], np.full(len(pose), "a"), pose, np.full(pose.shape, 0.01))
    for truck in both.trucks:
        check_pose_units(replace(recording, poses=poses), truck)
