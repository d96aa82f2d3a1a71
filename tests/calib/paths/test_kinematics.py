"""The kinematic models: their arcs, and derivatives that agree with differences."""

import math

import numpy as np
import pytest

from omnimate.calib.paths.kinematics import Differential
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import between
from studies.datasets.optiodom.drives import Tricycle

MODELS = [Differential(Truck(0.34, 0.15, 0.151)), Tricycle(0.16, 0.064, 0.02)]
READINGS = np.cumsum(np.random.default_rng(1).normal(0.0, 0.4, (9, 2)), axis=0)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("coordinate", range(3))
def test_derivatives_are_those_of_differences(model, coordinate):
    step = np.zeros(3)
    step[coordinate] = 1e-6
    ahead, behind = model.steps(READINGS, step).increment, model.steps(READINGS, -step).increment
    slope = between(behind, ahead) / 2e-6
    np.testing.assert_allclose(
        model.steps(READINGS, np.zeros(3)).jacobian[:, :, coordinate], slope, atol=1e-8
    )


def test_the_differential_robot_is_that_of_the_odometry():
    truck = Truck(0.34, 0.15, 0.151)
    turned = np.diff(READINGS, axis=0)
    expected = arc(turned[:, 0] * 0.075, turned[:, 1] * 0.0755, 0.34)
    np.testing.assert_allclose(Differential(truck).steps(READINGS, np.zeros(3)).increment, expected)


def test_e_s_scales_both_wheels_and_e_d_holds_their_mean():
    truck = Truck(0.34, 0.15, 0.151)
    scaled = Differential(truck).truck_at(np.array([0.0, math.log(1.01), 0.0]))
    assert scaled.wheel_diameter_left == pytest.approx(0.1515)
    assert scaled.wheel_diameter_right == pytest.approx(0.15251)
    apart = Differential(truck).truck_at(np.array([0.0, 0.0, 0.02]))
    assert apart.wheel_diameter_left + apart.wheel_diameter_right == pytest.approx(0.301)
    assert apart.wheel_diameter_right / apart.wheel_diameter_left == pytest.approx(
        0.151 / 0.15 * math.exp(0.02)
    )


def test_each_wheel_scatters_with_the_root_of_its_own_way():
    """Unit variance per metre of the left wheel alone: 1/2 along, 1/b of heading."""
    steps = Differential(Truck(0.34, 0.15, 0.15)).steps(np.array([[0.0, 0.0], [4.0, 0.0]]), np.zeros(3))
    assert steps.noise[0, 0, 2, 2] == pytest.approx(0.3 / 0.34**2)


def test_a_tricycle_with_its_wheel_across_turns_about_the_middle_of_its_axle():
    readings = np.array([[0.0, math.pi / 2], [1.0, math.pi / 2]])
    moved = Tricycle(0.15, 0.065).steps(readings, np.zeros(3)).increment[0]
    np.testing.assert_allclose(moved, [0.0, 0.0, 0.0325 / 0.15], atol=1e-15)


def test_a_tricycle_drives_a_circle_of_wheelbase_over_tan_of_its_steering():
    readings = np.stack([np.linspace(0.0, 100.0, 400), np.full(400, 0.3)], axis=-1)
    path = integrate(Tricycle(0.15, 0.065).steps(readings, np.zeros(3)).increment)
    radius = 0.15 / math.tan(0.3)
    np.testing.assert_allclose(np.hypot(path[:, 0], path[:, 1] - radius), radius)
