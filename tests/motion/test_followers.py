"""How truck b goes with truck a."""

import math

import numpy as np
import pytest

from omnimate.motion.followers import follow_like_car, keep_formation
from omnimate.motion.records import Settings, State
from omnimate.motion.stepping import sense
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
    sense(*pose_a, tuple(float(part) for part in linkage_of(pose_a, pose_b)), states[0])


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
