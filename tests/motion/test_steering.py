"""Steering one truck."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.motion.records import Settings
from omnimate.motion.steering import (
    approach_speed,
    clip,
    path_turn_rate,
    steer_arc,
    steer_line,
    steer_past,
    steer_turn,
)
from omnimate.vehicle.compiled import record


def limits(period=0.015, acceleration=0.5):
    own = record(Settings)
    own["trucks"], own["period"], own["speed"], own["acceleration"] = 1, period, 1.0, acceleration
    own["wheelbase"], own["radius"] = 0.34, 0.075
    own["tolerance"], own["turn_tolerance"] = 1.2e-5, 7e-5
    return own[0]


@given(
    way=st.floats(-5.0, 5.0),
    period=st.floats(0.002, 0.05),
    acceleration=st.floats(0.1, 2.0),
    delay=st.integers(0, 1),
)
def test_an_approach_stops_at_its_end_without_overshoot_even_one_step_late(way, period, acceleration, delay):
    own, tolerance = limits(period, acceleration), 1.2e-5
    speeds, speed, gone = [0.0], 0.0, 0.0
    for _ in range(round((abs(way) / 0.5 + 20.0) / period)):
        wanted = approach_speed(way - gone, tolerance, 0.5, own)
        speed += clip(wanted - speed, acceleration * period)
        speeds.append(speed)
        gone += speeds[-1 - delay] * period
        assert (gone - way) * math.copysign(1.0, way) <= tolerance
    assert abs(gone - way) <= tolerance
    assert speed == 0.0


def test_an_approach_brakes_with_less_than_the_limit():
    own = limits()
    ways = [0.001 * step for step in range(1, 1000)]
    for way in ways:
        speed = approach_speed(way, 1.2e-5, 10.0, own)
        assert speed - approach_speed(way - speed * 0.015, 1.2e-5, 10.0, own) <= 0.5 * 0.015


def test_a_truck_beside_its_path_turns_towards_it():
    assert path_turn_rate(0.3, 0.1, 0.0, 0.0, 0.0, 1.0) < 0.0
    assert path_turn_rate(0.3, -0.1, 0.0, 0.0, 0.0, 1.0) > 0.0
    assert path_turn_rate(0.3, 0.0, 0.0, 0.0, 0.5, 1.0) == pytest.approx(0.15)
    assert path_turn_rate(-0.01, 0.1, 0.0, 0.0, 0.0, 1.0) == 0.0


def test_a_line_driven_in_reverse_keeps_the_heading_and_goes_backwards():
    speed, turn, there = steer_line(2.0, 0.0, 0.0, 0.0, 0.0, math.pi, 1, 1.0, 0.3, 1e-5, limits())
    assert speed == pytest.approx(-0.3)
    assert turn == pytest.approx(0.0, abs=1e-12)
    assert not there


def test_a_turn_takes_the_wheels_to_the_speed_given():
    speed, turn, there = steer_turn(math.pi / 2.0, 0.2, 0, limits())
    assert speed == 0.0
    assert turn * 0.17 == pytest.approx(0.2)
    assert not there
    assert steer_turn(-6e-5, 0.2, 0, limits()) == (0.0, 0.0, True)


def test_on_the_arc_nothing_is_steered_beyond_its_curvature():
    for side in (1.0, -1.0):
        speed, turn, _ = steer_arc(0.0, 0.0, 0.0, 0.0, side * 2.0, side * 0.5, 3.0, 0.4, 1e-5, limits())
        assert turn == pytest.approx(side * 0.5 * speed)


def test_a_via_point_is_passed_when_it_is_near_enough_and_slows_the_truck_before():
    assert steer_past(0.0, 0.0, 0.0, 0.4, 0.0, 0.5, 2.0, 0.3, 0.15, limits())[2]
    far = steer_past(0.0, 0.0, 0.0, 4.0, 0.0, 0.5, 2.0, 0.3, 0.15, limits())
    near = steer_past(0.0, 0.0, 0.0, 0.501, 0.0, 0.5, 2.0, 0.3, 0.15, limits())
    assert far[:2] == (0.3, 0.0)
    assert near[0] == pytest.approx(0.15, abs=0.01)
