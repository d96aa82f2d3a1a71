"""What is true of a robot."""

import pytest

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.file import parse_vehicle


@pytest.fixture
def vehicle(robot_toml):
    return parse_vehicle(robot_toml, "robot")


def test_errors_change_the_wheelbase_and_the_ratio_of_the_wheels_but_not_their_mean(vehicle):
    true = with_errors(vehicle, {"a": 0.98}, {"a": 1.002, "b": 0.999})
    a, b = true.trucks["a"], true.trucks["b"]
    assert a.wheelbase == pytest.approx(0.98 * 0.340)
    assert b.wheelbase == 0.341
    assert a.wheel_diameter_right / a.wheel_diameter_left == pytest.approx(1.002)
    assert b.wheel_diameter_right / b.wheel_diameter_left == pytest.approx(0.999)
    assert a.wheel_diameter_right + a.wheel_diameter_left == pytest.approx(0.301)


def test_what_is_not_named_stays_as_it_was(vehicle):
    truck = with_errors(vehicle, {}, {}).trucks["a"]
    assert truck.wheelbase == 0.340
    assert (truck.wheel_diameter_left, truck.wheel_diameter_right) == pytest.approx((0.150, 0.151))


def test_a_negative_seed_is_refused(vehicle):
    with pytest.raises(SimulationError, match="seed -1"):
        Truth(vehicle, seed=-1)
