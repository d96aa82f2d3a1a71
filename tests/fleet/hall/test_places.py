import numpy as np
import pytest

from omnimate.fleet.hall.places import Place, creep_on_slopes, lose_travel, place_records
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.plant import constants_of
from omnimate.vcan_sim.records import State
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.compiled import compiled, record

STEP = 0.01  # [m]


@compiled
def drive_straight(places, sides, constants, states, steps, step):
    for _ in range(steps):
        states[0].travel[0] = step
        states[0].travel[1] = step
        lose_travel(places, sides, constants[0], states[0])
        states[0].pose[0, 0] += 0.5 * (states[0].travel[0] + states[0].travel[1])
        creep_on_slopes(places, constants[0], states[0])


def end_of(place, metres=4.0, y=0.0):
    """Return where a robot ends that drives along x through a place at 2 m."""
    vehicle = reference_single()
    constants, states = constants_of(Truth(vehicle), vehicle), record(State)
    states["pose"][0, 0, 1] = y
    places = place_records((place,))
    drive_straight(places, np.zeros((1, 4)), constants, states, round(metres / STEP), STEP)
    return states["pose"][0, 0]


@pytest.mark.parametrize(("y", "lost"), [(0.0, 0.003), (1.0, 0.0)])
def test_a_joint_costs_each_wheel_its_size_once_and_nothing_beyond_its_ends(y, lost):
    joint = Place("joint", 2.0, 0.0, reach=0.5, size=0.003, direction=np.pi / 2)
    assert end_of(joint, y=y)[0] == pytest.approx(4.0 - lost)


def test_an_oily_patch_costs_its_part_of_the_way_over_it():
    oil = Place("oil", 2.0, 0.0, reach=0.5, size=0.02)
    chord = 2.0 * np.sqrt(0.5**2 - 0.17**2)  # [m] of the wheels, which roll 170 mm beside the centre
    assert end_of(oil)[0] == pytest.approx(4.0 - 0.02 * chord, abs=2.0 * 0.02 * STEP)


def test_on_a_slope_the_robot_creeps_to_the_slopes_side():
    slope = Place("slope", 2.0, 0.0, reach=0.5, size=0.01, direction=np.pi / 2)
    assert end_of(slope)[1] == pytest.approx(0.01 * 1.0, abs=2.0 * 0.01 * STEP)


def test_an_unknown_kind_of_place_is_refused_with_the_words_that_there_are():
    with pytest.raises(SimulationError, match="expected one of joint, oil, slope"):
        Place("hole", 0.0, 0.0, 1.0, 1.0)
