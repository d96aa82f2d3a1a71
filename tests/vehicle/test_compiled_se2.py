"""The plane's geometry for compiled code agrees with the array functions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle import compiled_se2, linkage, se2
from omnimate.vehicle.arcs import arc, integrate, integrate_twists

numbers = st.floats(-9, 9)
poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-10, 10)).map(np.array)


def assert_close(value, expected):
    assert value == pytest.approx(expected, rel=0, abs=1e-11)


@given(st.floats(-1e4, 1e4))
def test_wrap_stays_in_its_interval_and_keeps_the_direction(angle):
    wrapped = compiled_se2.wrap(angle)
    assert -np.pi <= wrapped < np.pi
    assert_close(np.exp(1j * wrapped), np.exp(1j * angle))


@given(poses, numbers, numbers)
def test_points_and_vectors_turn_as_arrays_of_them_do(pose, x, y):
    assert_close(compiled_se2.rotate(pose[2], x, y), se2.rotate(pose[2], [x, y]))
    assert_close(compiled_se2.transform(pose, x, y), se2.transform(pose, [x, y]))


@given(poses, poses)
def test_composition_may_overwrite_its_arguments(first, second):
    expected = se2.compose(first, second)
    compiled_se2.compose(first, first, second)
    assert_close(first, expected)


@given(poses)
def test_matrices_are_those_of_arrays(pose):
    out = np.empty((3, 3))
    compiled_se2.rotation(out, pose[2])
    assert_close(out, se2.rotation(pose[2]))
    compiled_se2.transport(out, pose)
    assert_close(out, se2.transport(pose))


@given(poses, numbers, numbers, st.floats(0.1, 2.0))
def test_rolling_is_the_arc_of_the_wheels(pose, left, right, wheelbase):
    expected = integrate(arc(np.array([left]), np.array([right]), wheelbase), pose)[-1]
    compiled_se2.roll(pose, left, right, wheelbase)
    assert_close(pose, expected)


@given(poses, numbers, numbers, st.floats(-3, 3))
def test_gliding_is_a_step_along_a_twist(pose, forward, left, yaw):
    headings = np.array([pose[2], pose[2] + yaw])
    expected = integrate_twists(np.array([[forward, left, yaw]]), headings, pose)[-1]
    compiled_se2.glide(pose, forward, left, yaw)
    assert_close(pose, expected)


@given(poses, st.floats(-1, 1), st.floats(0.2, 3.0))
def test_truck_b_follows_on_the_link_and_shows_its_direction(pose_a, joint, length):
    pose_b = np.zeros(3)
    compiled_se2.follow(pose_b, pose_a, length, pose_a[2] - joint)
    assert_close(pose_b[:2], linkage.follower(pose_a, joint, 0.0, length)[:2])
    seen = compiled_se2.direction(pose_a, pose_b)
    assert_close(compiled_se2.wrap(seen - pose_a[2] + joint), 0.0)
