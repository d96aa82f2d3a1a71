"""The filter's prediction: the exact motion of two trucks, and its derivatives."""

import numpy as np
import pytest

from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prediction import predict_mean
from omnimate.ipec.filter.records import JOINT_A, LENGTH, STATES, WHEEL
from omnimate.vehicle.arcs import arc
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.linkage import follower, linkage_of
from omnimate.vehicle.se2 import compose

SLOW = 1e-3, -2e-3, 5e-4, 2e-3, 4e-3, -3e-3, 1e-3, 2e-3, 1e-3
MEAN = np.array([1.0, -2.0, 0.7, 0.9, -0.4, 1.05, *SLOW])
TRAVEL = np.array([0.021, 0.030, 0.027, 0.018])


@compiled
def predict(settings, states):
    predict_mean(settings[0], states[0])


@pytest.fixture
def move(robot):
    """Return a function from mean and travel to the predicted state record."""
    filter_ = Filter(robot)

    def moved(mean, travel):
        state = filter_.start().record.copy()
        state["mean"][0], state["travel"][0] = mean, travel
        predict(filter_.settings, state)
        return state[0]

    return moved


def test_the_trucks_move_along_their_arcs(move, robot):
    state = move(MEAN, TRAVEL)
    pose_a = np.array([MEAN[0], MEAN[1], MEAN[2] + MEAN[3]])
    pose_b = follower(pose_a, MEAN[3], MEAN[4], MEAN[5])
    true = TRAVEL * (1.0 + MEAN[WHEEL : WHEEL + 4])
    base = 0.340 * (1.0 + MEAN[10:12])
    after_a = compose(pose_a, arc(true[0], true[1], base[0]))
    after_b = compose(pose_b, arc(true[2], true[3], base[1]))
    assert [*state["mean"][:2], state["mean"][2] + state["mean"][3]] == pytest.approx(after_a, abs=1e-12)
    assert state["mean"][JOINT_A : LENGTH + 1] == pytest.approx(
        np.stack(linkage_of(after_a, after_b)), abs=1e-12
    )


def test_the_derivatives_are_those_of_the_motion(move):
    state = move(MEAN, TRAVEL).copy()
    for number in range(STATES):
        step = np.zeros(STATES)
        step[number] = 1e-6
        slope = (move(MEAN + step, TRAVEL)["mean"][:6] - move(MEAN - step, TRAVEL)["mean"][:6]) / 2e-6
        assert state["transition"][:, number] == pytest.approx(slope, abs=2e-4)
    for wheel in range(4):
        step = np.zeros(4)
        step[wheel] = 1e-6
        slope = (move(MEAN, TRAVEL + step)["mean"][:6] - move(MEAN, TRAVEL - step)["mean"][:6]) / 2e-6
        assert state["inputs"][:, wheel] == pytest.approx(slope, rel=0.01, abs=1e-3)
