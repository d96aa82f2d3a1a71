"""Corrected parameters."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.calib.apply import corrected_truck, corrected_vehicle, factors_between
from omnimate.vehicle.parameters import Bus, Encoder, ParameterError, Truck, VehicleParameters

FACTOR = st.floats(0.8, 1.25)
DIAMETER = st.floats(0.1, 0.2)


def mean(truck: Truck) -> float:
    return 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)


@given(DIAMETER, DIAMETER, FACTOR, FACTOR)
def test_mean_diameter_is_held(left: float, right: float, e_b: float, e_d: float) -> None:
    """Whatever the factors and the diameters before, (4.28) holds to rounding."""
    truck = Truck(0.34, left, right)
    assert mean(corrected_truck(truck, e_b, e_d)) == pytest.approx(mean(truck), rel=1e-12)


@given(FACTOR, FACTOR, FACTOR, FACTOR)
def test_a_second_pass_multiplies(b_1: float, d_1: float, b_2: float, d_2: float) -> None:
    """Two passes are one with the products of their factors."""
    truck = Truck(0.34, 0.15, 0.15)
    twice = corrected_truck(corrected_truck(truck, b_1, d_1), b_2, d_2)
    once = corrected_truck(truck, b_1 * b_2, d_1 * d_2)
    assert twice.wheelbase == pytest.approx(once.wheelbase, rel=1e-12)
    assert twice.wheel_diameter_left == pytest.approx(once.wheel_diameter_left, rel=1e-12)
    assert twice.wheel_diameter_right == pytest.approx(once.wheel_diameter_right, rel=1e-12)


@given(st.floats(0.5, 2.0))
def test_factors_of_equal_wheels_are_those_of_the_paper(e_d: float) -> None:
    """c_L + c_R = 2 and c_R / c_L = E_d, U (4.28)-(4.32)."""
    truck = Truck(0.34, 0.15, 0.15)
    factors = factors_between(truck, corrected_truck(truck, 1.0, e_d))
    assert factors.c_left + factors.c_right == pytest.approx(2.0, rel=1e-12)
    assert factors.c_right / factors.c_left == pytest.approx(e_d, rel=1e-12)


def test_impossible_results_are_refused() -> None:
    """A wheelbase of a hundred metres is an error of the parameters."""
    with pytest.raises(ParameterError, match="wheelbase"):
        corrected_truck(Truck(0.34, 0.15, 0.15), 300.0, 1.0)


def test_only_the_named_trucks_change() -> None:
    """The robot keeps everything but the calibrated truck."""
    wheels = (
        Encoder("a.left", 1, 0x181, 0, 32, signed=True, sign=1, counts_per_turn=4e4),
        Encoder("a.right", 2, 0x182, 0, 32, signed=True, sign=1, counts_per_turn=4e4),
    )
    robot = VehicleParameters("one", {"a": Truck(0.34, 0.15, 0.15)}, None, Bus(500_000, 0.015), wheels)
    better = Truck(0.336, 0.1499, 0.1501)
    assert corrected_vehicle(robot, {"a": better}).trucks == {"a": better}
    assert corrected_vehicle(robot, {}) == robot
