"""The trajectory about which the model is linear knows the past only."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.mismatch.recording.signals import signals_of

LINKAGE = ("joint_a", "joint_b", "link")


@pytest.fixture(scope="module")
def recording(drive, watched):
    return watched(drive(laps=1))


@pytest.fixture(scope="module")
def path(recording):
    return signals_of(recording).path


@settings(max_examples=15)
@given(share=st.floats(0.05, 0.95), more=st.integers(-200, 200))
def test_no_pose_depends_on_what_is_read_at_its_own_sample_or_later(recording, path, share, more):
    at = int(share * len(recording))
    counts = recording.counts.copy()
    for channel in LINKAGE:
        counts[at:, recording.vehicle.channels.index(channel)] += more
    np.testing.assert_array_equal(
        signals_of(replace(recording, counts=counts)).path[: at + 1], path[: at + 1]
    )


@settings(max_examples=15)
@given(share=st.floats(0.05, 0.95), more=st.floats(-0.1, 0.1))
def test_no_pose_depends_on_what_is_measured_from_outside_then_or_later(recording, path, share, more):
    at = int(share * len(recording))
    poses = recording.poses
    later = poses.time >= recording.time[at]
    moved = replace(poses, pose=poses.pose + np.where(later, more, 0.0)[:, None])
    np.testing.assert_array_equal(signals_of(replace(recording, poses=moved)).path[: at + 1], path[: at + 1])


def test_the_trajectory_comes_to_what_is_measured_within_seconds(recording, path):
    poses = recording.poses
    moved = replace(poses, pose=poses.pose + np.where(poses.time > 20.0, 0.1, 0.0)[:, None] * [1.0, 1.0, 0.0])
    away = signals_of(replace(recording, poses=moved)).path[..., :2] - path[..., :2]
    late = recording.time > 26.0
    np.testing.assert_allclose(away[late], 0.1, atol=0.01)


def test_the_trajectory_comes_to_what_is_read_within_seconds(recording, path):
    counts = recording.counts.copy()
    later = recording.time > 20.0
    counts[later, recording.vehicle.channels.index("link")] += 200  # a tenth of a millimetre each
    changed = signals_of(replace(recording, counts=counts)).path
    apart = [np.hypot(*(own[:, 0, :2] - own[:, 1, :2]).T) for own in (changed, path)]
    np.testing.assert_allclose((apart[0] - apart[1])[recording.time > 26.0], 0.02, atol=2e-3)
