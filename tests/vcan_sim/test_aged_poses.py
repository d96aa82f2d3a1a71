"""Poses that a measuring system reports late."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.clock_drift import ClockDrift
from omnimate.effects.latency import Latency
from omnimate.vcan_sim.altered_path import AgedPoses

STEP = 0.05


def driven(effects, steps):
    """Poses of a truck that drives 1 m/s along x and turns 0.5 rad/s, up to now."""
    poses = AgedPoses(effects, 0.0)
    for number in range(steps + 1):
        time = STEP * number
        poses.add(time, np.array([[time, 0.0, 0.5 * time]]))
    return poses.reported(0), STEP * steps


@given(st.floats(0.0, 2.0), st.integers(41, 200))
def test_a_late_pose_is_that_of_the_delay_ago(delay, steps):
    pose, now = driven([Latency("poses", delay)], steps)
    assert pose == pytest.approx([now - delay, 0.0, 0.5 * (now - delay)], abs=1e-9)


@given(st.floats(-0.1, 0.1), st.integers(2, 200))
def test_the_pose_of_a_clock_that_drifts_is_older_or_newer_by_rate_times_time(rate, steps):
    pose, now = driven([ClockDrift("poses", rate)], steps)
    assert pose[0] == pytest.approx(now - rate * now, abs=1e-9)


@given(st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_the_ages_of_two_effects_add_up(first, second):
    pose, now = driven([Latency("poses", first), Latency("poses", second)], 100)
    assert pose[0] == pytest.approx(now - first - second, abs=1e-9)


def test_without_effects_the_pose_is_the_present_one():
    pose, now = driven([], 7)
    assert pose == pytest.approx([now, 0.0, 0.5 * now])


def test_before_the_delay_has_passed_the_pose_is_that_of_the_start():
    pose, _ = driven([Latency("poses", 1.0)], 3)
    assert pose == pytest.approx([0.0, 0.0, 0.0])
