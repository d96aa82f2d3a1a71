"""The limits of each wheel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.motion.limits import drive_truck, stopped
from omnimate.motion.records import Settings, State
from omnimate.vehicle.compiled import record


def robot():
    own = record(Settings)
    own["period"], own["speed"], own["acceleration"], own["wheelbase"] = 0.015, 0.5, 0.4, 0.34
    return own[0], record(State)


@given(st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-5.0, 5.0)), min_size=1, max_size=30))
def test_no_wish_takes_a_wheel_beyond_its_speed_or_acceleration(wishes):
    own, states = robot()
    for speed, turn in wishes:
        before = states["speeds"].copy()
        drive_truck(0, speed, turn, states[0], own)
        assert np.abs(states["speeds"]).max() <= 0.5 + 1e-12
        assert np.abs(states["speeds"] - before).max() <= 0.4 * 0.015 + 1e-12


def test_too_fast_a_wish_keeps_its_curvature():
    own, states = robot()
    for _ in range(1000):
        drive_truck(0, 2.0, 3.0, states[0], own)
    left, right = states["speeds"][0, :2]
    assert (right - left) / 0.34 / (0.5 * (left + right)) == pytest.approx(1.5)


def test_a_truck_that_is_to_stand_stands_exactly():
    own, states = robot()
    for _ in range(10):
        drive_truck(1, 0.3, 0.2, states[0], own)
    assert not stopped(1, states[0])
    for _ in range(100):
        drive_truck(1, 0.0, 0.0, states[0], own)
    assert stopped(1, states[0])
    assert stopped(0, states[0])
