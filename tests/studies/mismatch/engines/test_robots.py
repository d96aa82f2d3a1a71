"""Random robots: the project reads their vehicle.toml as they are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.file import parse_vehicle
from studies.mismatch.engines.vocabulary import LINKAGE, WHEELS
from studies.mismatch.engines.writing import random_robot, toml_of

SEEDS, TRUCKS = st.integers(0, 2**32), st.sampled_from([1, 2])


def robot_of(seed, trucks):
    return random_robot(np.random.default_rng(seed), trucks)


@given(SEEDS, TRUCKS)
def test_the_same_seed_gives_the_same_robot(seed, trucks):
    assert robot_of(seed, trucks) == robot_of(seed, trucks)


@given(SEEDS, TRUCKS)
def test_a_robot_has_an_encoder_for_each_wheel_and_for_the_linkage_of_two_trucks(seed, trucks):
    robot = robot_of(seed, trucks)
    assert robot.channels == (WHEELS + LINKAGE if trucks == 2 else WHEELS[:2])
    assert len({device.node for device in robot.devices}) == len(robot.devices)


@given(SEEDS, TRUCKS)
def test_the_project_reads_a_robot_as_it_is(seed, trucks):
    robot = robot_of(seed, trucks)
    vehicle = parse_vehicle(toml_of(robot))
    assert vehicle.name == robot.name
    assert [truck.wheelbase for truck in vehicle.trucks.values()] == list(robot.wheelbase)
    for number, truck in enumerate(vehicle.trucks.values()):
        diameters = truck.wheel_diameter_left, truck.wheel_diameter_right
        assert diameters == pytest.approx(
            [2.0 * radius for radius in robot.radius[2 * number : 2 * number + 2]]
        )
    assert vehicle.bus.sync_period == robot.period
    assert (vehicle.linkage is None) == (trucks == 1)
    for encoder, device in zip(vehicle.encoders, robot.devices, strict=True):
        assert (encoder.channel, encoder.node, encoder.cob_id) == (device.channel, device.node, device.cob_id)
        assert (encoder.start_bit, encoder.bits, encoder.signed) == (
            device.start_bit,
            device.bits,
            device.signed,
        )
        assert (encoder.sign, encoder.zero) == (device.sign, device.zero)
