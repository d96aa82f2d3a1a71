"""What neither the poses before nor those after confirm is an outlier; what happened to a robot is none."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.mismatch.recording.pose_outliers import pose_outliers
from omnimate.vehicle.se2 import rotate

COUNT, SIGMA = 2000, np.array([2e-3, 2e-3, 3e-3])


def driven():
    """Return poses (M, 3) on a winding way."""
    along = np.linspace(0.0, 60.0, COUNT)
    heading = 1.5 * np.sin(0.5 * along)
    step = np.diff(along, prepend=along[0])
    return np.stack([np.cumsum(step * np.cos(heading)), np.cumsum(step * np.sin(heading)), heading], axis=1)


def noisy(seed=3):
    return driven() + SIGMA * np.random.default_rng(seed).normal(size=(COUNT, 3))


def test_of_noise_alone_hardly_anything_is_an_outlier():
    assert pose_outliers(noisy(), driven()).sum() <= 1


@settings(max_examples=25, deadline=None)
@given(
    at=st.integers(10, COUNT - 10),
    axis=st.sampled_from([0, 1, 2]),
    size=st.floats(10.0, 1e4),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_one_pose_far_off_is_found_on_its_axis(at, axis, size, sign):
    pose = noisy(at)
    pose[at, axis] += sign * min(size * SIGMA[axis], 1.0)
    assert pose_outliers(pose, driven())[at, axis]


@settings(max_examples=25, deadline=None)
@given(at=st.integers(10, COUNT - 10), size=st.floats(0.01, 0.5))
def test_a_robot_that_was_pushed_leaves_no_outlier(at, size):
    pose = noisy(at)
    pose[at:] += size * np.array([1.0, -1.0, 0.5])
    assert pose_outliers(pose, driven()).sum() <= 2


@settings(max_examples=25, deadline=None)
@given(angle=st.floats(-3.0, 3.0), x=st.floats(-50.0, 50.0), y=st.floats(-50.0, 50.0))
def test_it_does_not_matter_where_odometry_starts(angle, x, y):
    pose = noisy(5)
    pose[[300, 900]] += 0.1
    other = driven()
    other[:, :2] = rotate(angle, other[:, :2]) + np.array([x, y])
    other[:, 2] += angle
    np.testing.assert_array_equal(pose_outliers(pose, other), pose_outliers(pose, driven()))


def test_sparse_poses_are_left_alone():
    pose = noisy()
    assert not pose_outliers(pose[:8], driven()[:8]).any()
    pose[::2, 2] = np.nan
    assert pose_outliers(pose, driven()).shape == (COUNT, 3)
