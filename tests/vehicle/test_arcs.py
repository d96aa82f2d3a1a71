"""Exact arcs: one step or many, forth and back, and with sideways motion."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.arcs import (
    SMALL_ANGLE,
    SMALL_SLOPE_ANGLE,
    advance,
    arc,
    arc_jacobian,
    glide,
    integrate,
    integrate_twists,
    roll,
    sinc,
    sinc_slope,
    twists_along,
    wheel_levers,
)
from omnimate.vehicle.se2 import between


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 2), st.integers(1, 40))
def test_an_arc_in_one_step_or_in_many_ends_at_the_same_place(left, right, wheelbase, parts):
    whole = integrate(arc(np.array([left]), np.array([right]), wheelbase))[-1]
    cut = np.full(parts, 1.0 / parts)
    assert np.allclose(integrate(arc(left * cut, right * cut, wheelbase))[-1], whole, atol=1e-9)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_driving_back_undoes_an_arc(left, right):
    there_and_back = integrate(arc(np.array([left, -left]), np.array([right, -right]), 0.34))
    assert np.allclose(there_and_back[-1], 0.0, atol=1e-9)


def test_a_quarter_circle_by_hand():
    radius, wheelbase = 2.0, 0.5
    pose = arc((radius - 0.25) * math.pi / 2, (radius + 0.25) * math.pi / 2, wheelbase)
    assert np.allclose(pose, [radius, radius, math.pi / 2])


def test_a_tiny_turn_loses_no_precision():
    assert np.allclose(arc(1.0 - 1e-7, 1.0 + 1e-7, 1.0), [1.0, 1e-7, 2e-7], rtol=0, atol=1e-13)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 2), st.floats(-4, 4))
def test_single_steps_are_arcs_of_the_array_functions(left, right, wheelbase, theta):
    start = np.array([0.3, -0.2, theta])
    whole = integrate(arc(np.array([left]), np.array([right]), wheelbase), start)[-1]
    assert np.allclose(advance(tuple(start), left, right, wheelbase), whole, rtol=0, atol=1e-12)
    rolled, glided = start.copy(), start.copy()
    roll(rolled, left, right, wheelbase)
    assert np.allclose(rolled, whole, rtol=0, atol=1e-12)
    glide(glided, left, right, wheelbase)
    twist, heading = np.array([[left, right, wheelbase]]), np.array([theta, theta + wheelbase])
    assert np.allclose(glided, integrate_twists(twist, heading, start)[-1], rtol=0, atol=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_the_twists_along_a_path_lead_along_it(seed):
    chance = np.random.default_rng(seed)
    path = np.cumsum(chance.normal(0.0, 0.3, (20, 3)), axis=0)
    again = integrate_twists(twists_along(path), path[:, 2], path[0])
    assert np.allclose(again, path, rtol=0, atol=1e-12)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_a_twist_without_sideways_motion_is_the_arc_of_the_wheels(left, right):
    path = integrate(arc(np.array([left]), np.array([right]), 2.0))
    forward, aside, yaw = twists_along(path)[0]
    assert math.isclose(forward, 0.5 * (left + right), abs_tol=1e-12)
    assert math.isclose(aside, 0.0, abs_tol=1e-12)
    assert math.isclose(yaw, (right - left) / 2.0, abs_tol=1e-12)


def test_the_series_of_small_angles_meet_the_formulas():
    for limit, function, tolerance in ((SMALL_ANGLE, sinc, 1e-15), (SMALL_SLOPE_ANGLE, sinc_slope, 1e-11)):
        below, above = function(np.array([limit * (1.0 - 1e-9), limit * (1.0 + 1e-9)]))
        assert abs(above - below) < tolerance


@given(st.floats(-1.5, 1.5))
def test_the_slope_is_that_of_the_ratio(half):
    step = 1e-5
    slope = (float(sinc(half + step)) - float(sinc(half - step))) / (2.0 * step)
    assert math.isclose(float(sinc_slope(half)), slope, abs_tol=1e-9)


@given(st.floats(-2.0, 2.0), st.floats(-1.0, 1.0), st.sampled_from([1e-9, 1e-5, 1.0]))
def test_the_jacobian_of_an_arc_holds_for_turns_of_any_size(way, turn, size):
    wheels = np.array([way - 0.5 * size * turn, way + 0.5 * size * turn, 1.0])
    for column, step in enumerate(1e-6 * np.eye(3)):
        slope = between(arc(*(wheels - step)), arc(*(wheels + step))) / 2e-6
        assert np.allclose(arc_jacobian(*wheels)[:, column], slope, rtol=0, atol=1e-5)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3))
def test_a_metre_of_travel_moves_a_later_pose_by_its_lever(heading, x, y):
    """The wheel's own short arc turns the truck, and with it all that follows."""
    levers = wheel_levers(np.array(heading), np.array([x, y]), 0.34)
    way = between((0.0, 0.0, heading), (x, y, 0.0))
    for column, wheels in enumerate(1e-6 * np.eye(2)):
        there, back = (
            integrate([arc(*(sign * wheels), 0.34), way], (0.0, 0.0, heading))[-1] for sign in (1, -1)
        )
        assert np.allclose(levers[:, column], (there - back) / 2e-6, rtol=0, atol=1e-7)
