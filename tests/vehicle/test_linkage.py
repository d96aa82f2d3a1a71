"""The linkage: round trips and the signs of the spec."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.linkage import follower, link_heading, linkage_of, place_follower
from omnimate.vehicle.se2 import wrap

angles = st.floats(-3.1, 3.1)
trucks = st.tuples(st.floats(-9, 9), st.floats(-9, 9), angles).map(np.array)


@given(trucks, angles, angles, st.floats(0.1, 3))
def test_follower_and_linkage_are_inverse(a, joint_a, joint_b, length):
    found = linkage_of(a, follower(a, joint_a, joint_b, length))
    assert np.allclose(np.cos(found[0] - joint_a), 1)
    assert np.isclose(found[2], length)
    assert np.allclose(np.cos(found[1] - joint_b), 1)
    b = np.zeros(3)
    place_follower(b, a, length, a[2] - joint_a)
    assert np.allclose(b[:2], follower(a, joint_a, joint_b, length)[:2], rtol=0, atol=1e-11)
    assert np.isclose(np.cos(link_heading(a, b) - a[2] + joint_a), 1)


@given(trucks, angles, angles, st.floats(0.1, 3))
def test_the_linkage_seen_from_its_other_end_leads_back(a, joint_a, joint_b, length):
    back = follower(follower(a, joint_a, joint_b, length), joint_b, joint_a, -length)
    assert np.allclose(back[:2], a[:2])
    assert np.isclose(wrap(back[2] - a[2]), 0, atol=1e-9)


def test_in_line_both_joints_are_zero_and_a_left_turn_of_a_is_a_positive_joint_a():
    joint_a, joint_b, length = linkage_of((1.0, 0.0, 0.2), (0.0, 0.0, -0.1))
    assert (joint_a, joint_b, length) == (0.2, -0.1, 1.0)


def test_many_poses_at_once():
    a = np.zeros((5, 3))
    b = follower(a, np.linspace(-1, 1, 5), 0.0, 1.0)
    assert b.shape == (5, 3)
    assert math.isclose(linkage_of(a, b)[0][0], -1.0)
