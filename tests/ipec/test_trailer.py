"""The encoder trailer: the robot's turn follows from the joint, C 7."""

import numpy as np
import pytest

from omnimate.ipec.trailer import Trailer, TrailerState, step, track
from omnimate.vehicle.arcs import arc, integrate

TRAILER = Trailer(wheelbase=0.34, hitch=0.2, length=0.8)
FINE = 200  # steps of the reference integration per sample


def drive(count=1500, lost=0.0, seed=2):
    """Return rolled travel `(N, 2)`, joint `(N,)`, true poses `(N, 3)` of a robot that tows the trailer."""
    chance = np.random.default_rng(seed)
    turn = 0.0008 * np.cumsum(chance.normal(0.0, 0.1, count))
    travel = np.stack([0.004 - turn, 0.004 + turn], axis=1)
    true = travel.copy()
    true[count // 2, 1] -= lost
    fine = np.repeat(true / FINE, FINE, axis=0)
    poses = integrate(arc(fine[:, 0], fine[:, 1], TRAILER.wheelbase))
    joint = np.zeros(len(fine) + 1)
    way, turned = fine.mean(axis=1), (fine[:, 1] - fine[:, 0]) / TRAILER.wheelbase
    for index in range(len(fine)):
        gamma = joint[index]
        towed = (way[index] * np.sin(gamma) - TRAILER.hitch * turned[index] * np.cos(gamma)) / TRAILER.length
        joint[index + 1] = gamma + turned[index] - towed
    return travel, joint[::FINE], poses[::FINE]


def test_without_errors_nothing_is_corrected():
    travel, joint, poses = drive(400)
    path, corrections = track(TRAILER, TrailerState(poses[0], joint[0]), travel, joint[1:])
    assert np.abs(corrections).max() < 1e-6
    assert path == pytest.approx(poses[1:], abs=1e-4)


def test_a_bump_under_one_wheel_is_corrected():
    travel, joint, poses = drive(lost=0.003)
    start = TrailerState(poses[0], joint[0])
    rolled = integrate(arc(travel[:, 0], travel[:, 1], TRAILER.wheelbase))
    path, corrections = track(TRAILER, start, travel, joint[1:])
    assert np.degrees(abs(rolled[-1, 2] - poses[-1, 2])) == pytest.approx(0.5, abs=0.01)
    assert np.degrees(abs(path[-1, 2] - poses[-1, 2])) < 0.1
    assert np.argmax(np.abs(corrections)) == 750
    assert np.degrees(abs(corrections[750])) == pytest.approx(0.5, abs=0.1)


def test_stepwise_and_at_once_are_equal_also_where_the_joint_was_not_read():
    travel, joint, poses = drive(100, lost=0.001)
    joint[30:40] = np.nan
    state = TrailerState(poses[0])
    path, corrections = track(TRAILER, state, travel, joint[1:])
    for index in range(len(travel)):
        state = step(TRAILER, state, *travel[index], joint[index + 1])
        assert np.array_equal(state.pose, path[index])
        assert state.correction == corrections[index]
