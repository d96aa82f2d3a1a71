"""Poses in the filter's state: derivatives are those of the pose, and sigmas follow from them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.filter.poses import fill_pose, fill_pose_jacobian
from omnimate.ipec.filter.records import JOINT_A, JOINT_B, LENGTH, LINK, STATES, X, Y
from omnimate.vehicle.linkage import follower, linkage_of

seeds, trucks = st.integers(0, 2**32 - 1), st.integers(0, 1)


def estimate_by(seed):
    """Return a mean `(15,)` and a covariance `(15, 15)` of chance, with a link of about a metre."""
    chance = np.random.default_rng(seed)
    mean, root = chance.normal(size=STATES), chance.normal(size=(STATES, STATES))
    mean[LENGTH] = 1.0 + 0.1 * chance.random()
    return mean, root @ root.T


def pose_of(mean, truck):
    pose, sigma = np.empty(3), np.empty(3)
    fill_pose(mean, np.eye(STATES), truck, pose, sigma)
    return pose


@given(seeds)
def test_both_poses_have_the_linkage_that_the_state_says(seed):
    mean, _ = estimate_by(seed)
    pose_a, pose_b = pose_of(mean, 0), pose_of(mean, 1)
    assert pose_a[:2] == pytest.approx(mean[[X, Y]])
    assert pose_b == pytest.approx(follower(pose_a, mean[JOINT_A], mean[JOINT_B], mean[LENGTH]), abs=1e-9)
    length = np.stack(linkage_of(pose_a, pose_b))[2]
    assert length == pytest.approx(mean[LENGTH])
    assert pose_a[2] == pytest.approx(mean[LINK] + mean[JOINT_A])


@given(seeds, trucks)
def test_the_rows_are_the_derivatives_of_the_pose(seed, truck):
    mean, _ = estimate_by(seed)
    rows = np.empty((3, STATES))
    fill_pose_jacobian(mean, truck, rows)
    for state in range(STATES):
        step = np.zeros(STATES)
        step[state] = 1e-6
        slope = (pose_of(mean + step, truck) - pose_of(mean - step, truck)) / 2e-6
        assert rows[:, state] == pytest.approx(slope, abs=1e-6)


@given(seeds, trucks)
def test_the_sigmas_are_those_of_the_rows_and_the_covariance(seed, truck):
    mean, covariance = estimate_by(seed)
    pose, sigma, rows = np.empty(3), np.empty(3), np.empty((3, STATES))
    fill_pose(mean, covariance, truck, pose, sigma)
    fill_pose_jacobian(mean, truck, rows)
    assert sigma**2 == pytest.approx(np.diag(rows @ covariance @ rows.T), rel=1e-6, abs=1e-9)
