"""Two robots that see each other: as good as a linkage, and patient when they do not see."""

import numpy as np
import pytest

from omnimate.ipec.unconnected import PairState, step, track
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.se2 import wrap

WHEELBASE = np.array([0.34, 0.40])
START = np.array([[0.0, 0.0, 0.3], [-2.0, 1.0, -0.4]])


def drive(count=2000, lost=0.0, seed=4):
    """Return what the wheels roll, what the robots see, and where they truly are `(N, 2, 3)`."""
    chance = np.random.default_rng(seed)
    travel = 0.004 + 0.001 * np.cumsum(chance.normal(0.0, 0.02, (count, 4)), axis=0)
    true = travel.copy()
    true[count // 4, 1] -= lost
    poses = np.stack(
        [integrate(arc(*true[:, 2 * k : 2 * k + 2].T, WHEELBASE[k]), START[k]) for k in (0, 1)], 1
    )
    a, b = poses[1:, 0], poses[1:, 1]
    line = np.arctan2(a[:, 1] - b[:, 1], a[:, 0] - b[:, 0])
    sight = [np.hypot(*(a - b)[:, :2].T), wrap(line + np.pi - a[:, 2]), wrap(line - b[:, 2])]
    return travel, np.stack(sight, axis=1), poses[1:]


def test_without_errors_both_robots_are_where_they_are():
    travel, sight, poses = drive()
    assert track(PairState(START), travel, sight, WHEELBASE) == pytest.approx(poses, abs=1e-9)


def test_a_bump_under_one_robot_is_seen_by_both():
    travel, sight, poses = drive(lost=0.003)
    blind = track(PairState(START), travel, np.full_like(sight, np.nan), WHEELBASE)
    path = track(PairState(START), travel, sight, WHEELBASE)
    assert np.degrees(abs(blind[-1, 0, 2] - poses[-1, 0, 2])) == pytest.approx(0.5, abs=0.01)
    assert np.degrees(np.abs(path[..., 2] - poses[..., 2]).max()) < 0.1
    assert np.hypot(*(path[-1, 0] - poses[-1, 0])[:2]) < 0.01


def test_stepwise_and_at_once_are_equal_and_a_step_changes_no_state():
    travel, sight, _ = drive(200, lost=0.003)
    sight[50:80, 1] = np.nan
    state = PairState(START)
    path = track(state, travel, sight, WHEELBASE)
    for index in range(len(travel)):
        before = state.poses.copy()
        following = step(state, travel[index], sight[index], WHEELBASE)
        assert np.array_equal(state.poses, before)
        state = following
        assert np.array_equal(state.poses, path[index])
