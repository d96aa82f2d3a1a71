"""The filter's prediction: the exact motion of two trucks, and its derivatives."""

import numpy as np
import pytest

from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.prediction import differentiate, predict_mean
from omnimate.ipec.filter.records import CREEP, JOINT_A, LENGTH, LINK, STATES, WHEEL, WHEELBASE
from omnimate.vehicle.arcs import arc
from omnimate.vehicle.linkage import follower, linkage_of
from omnimate.vehicle.se2 import compose

SLOW = 1e-3, -2e-3, 5e-4, 2e-3, 4e-3, -3e-3, 0.0, 0.0, 1e-3, 2e-3, 1e-3
MEAN = np.array([1.0, -2.0, 0.7, 0.9, -0.4, 1.05, 0.0, 0.0, *SLOW])
TRAVEL = np.array([0.021, 0.030, 0.027, 0.018])


@pytest.fixture
def move(robot):
    """Return a function from mean and travel to the predicted state record."""
    filter_ = Filter(robot)

    def moved(mean, travel):
        state = filter_.start().record.copy()
        state["mean"][0], state["travel"][0], state["step_travel"][0] = mean, travel, travel
        state["step_start"][0], state["samples"] = mean[LINK : LINK + 4], 1
        predict_mean(filter_.settings[0], state[0])
        differentiate(filter_.settings[0], state[0])
        return state[0]

    return moved


def test_the_trucks_move_along_their_arcs(move, robot):
    state = move(MEAN, TRAVEL)
    pose_a = np.array([MEAN[0], MEAN[1], MEAN[2] + MEAN[3]])
    pose_b = follower(pose_a, MEAN[3], MEAN[4], MEAN[5])
    true = TRAVEL * (1.0 + MEAN[WHEEL : WHEEL + 4])
    base = 0.340 * (1.0 + MEAN[WHEELBASE : WHEELBASE + 2])
    after_a = compose(pose_a, arc(true[0], true[1], base[0]))
    after_b = compose(pose_b, arc(true[2], true[3], base[1]))
    assert [*state["mean"][:2], state["mean"][2] + state["mean"][3]] == pytest.approx(after_a, abs=1e-12)
    assert state["mean"][JOINT_A : LENGTH + 1] == pytest.approx(
        np.stack(linkage_of(after_a, after_b)), abs=1e-12
    )


def test_a_truck_creeps_outwards_in_a_turn(move, robot):
    """Sideways speed = creep x speed x yaw rate: 0.1 s, 25.5 mm and 9 mm over 340 mm in 15 ms."""
    creeping = MEAN.copy()
    creeping[CREEP] = 0.1
    place, without = move(creeping, TRAVEL)["mean"][:2], move(MEAN, TRAVEL)["mean"][:2]
    way, turn = 0.0255, 0.0090 / 0.340
    outwards = 0.1 * way * turn / robot.bus.sync_period
    assert np.hypot(*(place - without)) == pytest.approx(outwards, rel=0.02)


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
