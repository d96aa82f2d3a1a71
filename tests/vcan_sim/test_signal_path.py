"""The stages of the signal path, each by itself."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vcan_sim.plant import constants_of
from omnimate.vcan_sim.records import State
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.signal_path import couple, drive, glide, move, read_wheels, roll
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.compiled import record
from omnimate.vehicle.linkage import linkage_of

VEHICLE = reference_vehicle()
CONSTANTS = constants_of(Truth(VEHICLE, servo=2.0), VEHICLE)[0]
PERIOD = 0.015
many = settings(max_examples=50)

four = st.tuples(*[st.floats(-50.0, 50.0)] * 4)
headings = st.tuples(*[st.floats(-3.0, 3.0)] * 2)
near = st.tuples(*[st.floats(-0.02, 0.02)] * 4)


def state():
    return record(State)[0]


@many
@given(four, four)
def test_drives_follow_their_command_as_far_as_their_acceleration_allows(before, command):
    robot = state()
    robot["speed"] = before
    drive(CONSTANTS, robot, np.array(command), PERIOD)
    most = 2.0 / 0.075 * PERIOD
    change = np.clip(np.subtract(command, before), -most, most)
    assert robot["speed"] == pytest.approx(np.add(before, change))
    assert robot["turned"] == pytest.approx(robot["speed"] * PERIOD)


@many
@given(four)
def test_wheel_counts_are_the_lines_that_have_passed(angles):
    robot = state()
    robot["angle"] = angles
    read_wheels(CONSTANTS, robot)
    exact = CONSTANTS["offset"][:4] + CONSTANTS["scale"][:4] * np.array(angles)
    assert np.all((exact - 1.0 < robot["counts"][:4]) & (robot["counts"][:4] <= exact))


@many
@given(four)
def test_the_way_rolled_grows_in_both_directions(turned):
    robot = state()
    robot["turned"] = turned
    roll(CONSTANTS, robot)
    assert robot["travel"] == pytest.approx(0.075 * np.array(turned))
    assert np.all(robot["rolled"] == np.abs(robot["travel"]))


@many
@given(near, headings)
def test_trucks_glide_along_the_twist_of_their_wheels_as_they_move_by_the_wheels(travel, heading):
    moved, glided = state(), state()
    for robot in (moved, glided):
        robot["travel"], robot["pose"][:, 2] = travel, heading
    move(CONSTANTS, moved)
    left, right = np.array(travel[::2]), np.array(travel[1::2])
    yaw = (right - left) / CONSTANTS["wheelbase"]
    glide(CONSTANTS, glided, np.stack([0.5 * (left + right), np.zeros(2), yaw], axis=1))
    assert glided["pose"] == pytest.approx(moved["pose"], abs=1e-12)


@many
@given(headings, st.floats(-1.0, 1.0))
def test_the_linkage_takes_up_what_lies_between_the_trucks(heading, direction):
    robot = state()
    robot["pose"][0, :2] = math.cos(direction), math.sin(direction)
    robot["pose"][:, 2] = heading
    couple(CONSTANTS, robot)
    joint_a, joint_b, length = linkage_of(robot["pose"][0], robot["pose"][1])
    turns = (robot["joint"] - [joint_a, joint_b]) / (2.0 * math.pi)
    assert turns == pytest.approx(np.round(turns), abs=1e-9)
    assert robot["length"] == pytest.approx(length)
    assert not robot["end_stop"]


@many
@given(st.floats(0.0, 3.0))
def test_the_end_stop_is_noted_where_the_link_is_too_short_or_too_long(length):
    robot = state()
    robot["pose"][0, 0] = length
    couple(CONSTANTS, robot)
    assert bool(robot["end_stop"]) == (not CONSTANTS["shortest"] <= length <= CONSTANTS["longest"])
