"""The limits of each wheel, and how truck b goes with truck a."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.motion.records import Settings, State
from omnimate.motion.stepping import drive_truck, follow_like_car, keep_formation, stopped, update_poses
from omnimate.vehicle.arcs import advance
from omnimate.vehicle.compiled import record
from omnimate.vehicle.linkage import linkage_of

LENGTH, WHEELBASE, PERIOD = 1.0, 0.34, 0.015


def robot(pose_a, pose_b):
    own, states = record(Settings), record(State)
    own["trucks"], own["link_length"], own["wheelbase"] = 2, LENGTH, WHEELBASE
    see(states, pose_a, pose_b)
    states["formation"] = math.atan2(pose_a[1] - pose_b[1], pose_a[0] - pose_b[0])
    return own[0], states


def see(states, pose_a, pose_b):
    update_poses(*pose_a, tuple(float(part) for part in linkage_of(pose_a, pose_b)), states[0])


def go(pose, speed, turn):
    rim = 0.5 * turn * WHEELBASE
    return advance(pose, (speed - rim) * PERIOD, (speed + rim) * PERIOD, WHEELBASE)


def test_the_linkage_tells_where_truck_b_is():
    pose_a, pose_b = (1.0, 2.0, 0.3), (0.2, 1.3, -0.4)
    _, states = robot(pose_a, pose_b)
    assert states["pose"][0] == pytest.approx(np.array([pose_a, pose_b]))


@pytest.mark.parametrize("curvature", [0.0, 1.0, -1.5])
def test_like_a_car_truck_b_faces_truck_a_and_keeps_the_distance(curvature):
    pose_a, pose_b = (0.0, 0.0, 0.0), (-1.03, 0.2, -0.3)
    own, states = robot(pose_a, pose_b)
    for _ in range(2000):
        see(states, pose_a, pose_b)
        pose_b = go(pose_b, *follow_like_car(0.3, states[0], own))
        pose_a = go(pose_a, 0.3, 0.3 * curvature)
    _, joint_b, length = linkage_of(pose_a, pose_b)
    assert abs(joint_b) < 0.5
    assert length == pytest.approx(LENGTH, abs=0.05)


@pytest.mark.parametrize("speed", [0.3, -0.3])
@pytest.mark.parametrize("beside", [0.0, math.pi / 2.0])
def test_in_formation_truck_b_takes_on_heading_and_place_forward_and_in_reverse(speed, beside):
    pose_a = (0.0, 0.0, 0.0)
    pose_b = (-math.cos(beside) + 0.02, -math.sin(beside) - 0.03, 0.1)
    own, states = robot(pose_a, pose_b)
    states["formation"] = beside
    for _ in range(3000):
        see(states, pose_a, pose_b)
        pose_b = go(pose_b, *keep_formation(speed, 0.0, states[0], own))
        pose_a = go(pose_a, speed, 0.0)
    offset = np.subtract(pose_a, pose_b)
    assert offset == pytest.approx([math.cos(beside), math.sin(beside), 0.0], abs=1e-3)


def test_in_formation_both_turn_on_the_spot_together_and_the_deck_does_not():
    pose_a, pose_b = (0.0, 0.0, 0.0), (-1.0, 0.0, 0.0)
    own, states = robot(pose_a, pose_b)
    for _ in range(200):
        see(states, pose_a, pose_b)
        pose_b = go(pose_b, *keep_formation(0.0, 1.0, states[0], own))
        pose_a = go(pose_a, 0.0, 1.0)
    assert pose_b == pytest.approx((-1.0, 0.0, pose_a[2]), abs=1e-9)


def limited():
    own = record(Settings)
    own["period"], own["speed"], own["acceleration"], own["wheelbase"] = 0.015, 0.5, 0.4, 0.34
    return own[0], record(State)


@given(st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-5.0, 5.0)), min_size=1, max_size=30))
def test_no_wish_takes_a_wheel_beyond_its_speed_or_acceleration(wishes):
    own, states = limited()
    for speed, turn in wishes:
        before = states["speeds"].copy()
        drive_truck(0, speed, turn, states[0], own)
        assert np.abs(states["speeds"]).max() <= 0.5 + 1e-12
        assert np.abs(states["speeds"] - before).max() <= 0.4 * 0.015 + 1e-12


def test_too_fast_a_wish_keeps_its_curvature():
    own, states = limited()
    for _ in range(1000):
        drive_truck(0, 2.0, 3.0, states[0], own)
    left, right = states["speeds"][0, :2]
    assert (right - left) / 0.34 / (0.5 * (left + right)) == pytest.approx(1.5)


def test_a_truck_that_is_to_stand_stands_exactly():
    own, states = limited()
    for _ in range(10):
        drive_truck(1, 0.3, 0.2, states[0], own)
    assert not stopped(1, states[0])
    for _ in range(100):
        drive_truck(1, 0.0, 0.0, states[0], own)
    assert stopped(1, states[0])
    assert stopped(0, states[0])
