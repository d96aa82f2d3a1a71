"""The floor: its roughness, and bumps with the numbers of CLAPPER: R = 75 mm, h = 10 mm, b = 340 mm."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.effects.crossing import cable_loss, chord_loss, edge_loss
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.floor import Bump, Floor, bumps_under
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.sonar import Sonar
from tests.vcan_sim.test_simulate import return_errors


@pytest.mark.parametrize("roughness", [-1e-4, math.nan, math.inf])
def test_a_roughness_that_no_floor_has_is_refused(roughness):
    with pytest.raises(SimulationError, match="roughness"):
        Floor(roughness)


def test_the_heading_scatters_with_the_square_root_of_the_way_whatever_the_step(alone):
    turns = {}
    for dt in (0.005, 0.02):
        headings = []
        for seed in range(200):
            plant = Plant(Truth(alone, floor=Floor(1e-3), servo=1e9, seed=seed), alone)
            for _ in range(round(2.0 / (4.0 * 0.075 * dt))):
                plant.step((4.0, 4.0), dt)
            headings.append(plant.pose("a")[2])
        turns[dt] = np.std(headings)
    wanted = 1e-3 * math.sqrt(2.0 * 2.0) / 0.340
    assert list(turns.values()) == pytest.approx([wanted, wanted], rel=0.2)


def test_a_robot_that_stands_is_not_shaken(alone):
    plant = Plant(Truth(alone, floor=Floor(1e-3)), alone)
    for _ in range(100):
        plant.step((0.0, 0.0), 0.015)
    assert not plant.pose("a").any()


def test_on_concrete_the_return_position_of_a_4_m_square_scatters_by_25_mm_in_x_and_y(alone):
    errors = []
    for seed in range(4):
        truth = Truth(alone, floor=Floor(CONCRETE_ROUGHNESS), sonar=Sonar(sigma=0.0), seed=seed)
        errors += return_errors(simulate(alone, truth, umbmark(runs=40)), "a").tolist()
    scatter = np.std(errors, axis=0)[:2]
    assert len(errors) == 320
    assert scatter == pytest.approx([0.025, 0.025], rel=0.12)  # three standard errors of 320 runs


R, H, B = 0.075, 0.010, 0.340
VEHICLE = reference_single()


def degrees(lost):
    """The turn that a loss of travel on one side makes, C (4)."""
    return math.degrees(math.asin(lost / B))


def test_the_losses_are_the_figures_of_clapper_table_1_and_of_the_exact_arc():
    assert 1000.0 * chord_loss(R, H) == pytest.approx(2.63, abs=0.005)
    assert 1000.0 * 10.0 * chord_loss(R, H) / B == pytest.approx(77.0, abs=0.5)
    assert 1000.0 * edge_loss(R, H) == pytest.approx(3.51, abs=0.005)


@pytest.mark.parametrize(("loss", "turn"), [(chord_loss, 0.44), (edge_loss, 0.59), (cable_loss, 0.57)])
def test_a_bump_turns_the_truck_by_so_many_degrees(loss, turn):
    assert degrees(loss(R, H)) == pytest.approx(turn, abs=0.005)


@given(radius=st.floats(0.02, 0.5), part=st.floats(0.001, 0.3))
def test_every_model_loses_travel_and_more_on_a_higher_bump(radius, part):
    for loss in (chord_loss, edge_loss, cable_loss):
        assert 0.0 < loss(radius, part * radius) < loss(radius, 1.1 * part * radius) < radius


def test_bumps_under_a_wheel_are_evenly_spaced():
    bumps = bumps_under("a.right", 4, 10.0, 18.0, lap=3, height=0.009)
    assert [bump.after for bump in bumps] == [11.0, 13.0, 15.0, 17.0]
    assert {(bump.wheel, bump.lap, bump.height) for bump in bumps} == {("a.right", 3, 0.009)}


def test_a_bump_as_high_as_the_wheels_axle_is_refused():
    with pytest.raises(SimulationError, match="too high"):
        Bump(height=0.08).crossing(R)


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


def test_a_crossing_is_longer_than_what_it_loses():
    crossing = Bump(0.01, "cable").crossing(R)
    assert crossing.lost == cable_loss(R, 0.01)
    assert crossing.rolled == pytest.approx(2.0 * math.sqrt(2.0 * R * H) + crossing.lost)
