"""Robots for the tests of this room."""

from dataclasses import replace

import pytest

from omnimate.vehicle.file import parse_vehicle


@pytest.fixture
def two_trucks(robot_toml):
    return parse_vehicle(robot_toml, "robot")


@pytest.fixture
def one_truck(two_trucks):
    return replace(
        two_trucks, trucks={"a": two_trucks.trucks["a"]}, linkage=None, encoders=two_trucks.encoders[:2]
    )
