"""Obstacles of the floor: what a crossing costs does not depend on the steps in which it is made."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vcan_sim.bumps import Bump
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.truth import Truth

VEHICLE = reference_single()


def heading_after(bump, speeds, period):
    plant = Plant(Truth(VEHICLE, floor=Floor(0.0, (bump,)), servo=1e9), VEHICLE)
    for speed in speeds:
        plant.step((speed, speed), period)
    return float(plant.pose("a")[2])


@settings(max_examples=30)
@given(
    shape=st.sampled_from(["chord", "edge", "cable"]),
    height=st.floats(0.002, 0.03),
    period=st.floats(0.002, 0.1),
    after=st.floats(0.0, 0.2),
)
def test_a_crossing_turns_the_truck_by_the_loss_over_the_wheelbase_whatever_the_step(
    shape, height, period, after
):
    bump = Bump(height, shape, "a.left", after)
    speeds = [4.0] * math.ceil((after + bump.crossing(0.075).rolled + 0.1) / (4.0 * 0.075 * period))
    turn = bump.crossing(0.075).lost / VEHICLE.trucks["a"].wheelbase
    assert heading_after(bump, speeds, period) == pytest.approx(turn, abs=1e-9)


def test_a_wheel_that_stops_on_the_obstacle_loses_the_rest_when_it_goes_on():
    bump = Bump(0.01, "cable", "a.left", 0.0)
    without, with_stop = ([4.0] * 60, [4.0] * 5 + [0.0] * 50 + [4.0] * 55)
    assert heading_after(bump, with_stop, 0.015) == pytest.approx(heading_after(bump, without, 0.015))
