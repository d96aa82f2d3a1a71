"""The path designer: the comparison of NOTES.md, and bounds that a simulated calibration attains."""

import math

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.paths.design import (
    MOTION_CAPTURE_HEADING_SIGMA,
    SONAR_HEADING_SIGMA,
    Space,
    assess,
    compare_designs,
    counted_spin,
    free_lap,
    open_straight,
    square,
    straights_and_spins,
)
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import calibrate_truck
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.arcs import integrate
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.parameters import Truck

TRUCK = Truck(0.340, 0.150, 0.150)


@pytest.fixture(scope="module")
def designs():
    found = compare_designs(TRUCK, Space(14.0, 4.0, 160.0, MOTION_CAPTURE_HEADING_SIGMA))
    return {one.name.split(",")[0].split(" of")[0]: one for one in found}


def test_160_m_of_straights_and_spins_leave_8_7_mm_where_heading_is_measured(designs):
    assert 1e3 * designs["open straights"].residual_error == pytest.approx(8.7, abs=0.3)


def test_umbmark_of_the_same_way_leaves_half_as_much_again(designs):
    """13.0 mm with independent scatter of x and y; 13.8 with the chain's own."""
    assert 1e3 * designs["UMBmark"].residual_error == pytest.approx(13.4, abs=0.6)
    assert designs["UMBmark"].laps == 10


def test_one_direction_or_out_and_back_identify_nothing(designs):
    for name in ("squares", "14 m out"):
        assert math.isnan(designs[name].residual_error)
        assert {"wheelbase", "diameter ratio (E_d)"} <= {one.name for one in designs[name].held}


def test_no_closed_square_identifies_e_s_and_open_straights_do(designs):
    assert "mean diameter (E_s)" in {one.name for one in designs["UMBmark"].held}
    assert designs["open straights"].held == ()
    assert designs["open straights"].sigma[1] < 1e-3


def test_the_best_drive_comes_first_and_those_that_tell_too_little_last():
    found = compare_designs(TRUCK, Space(14.0, 4.0, 160.0, MOTION_CAPTURE_HEADING_SIGMA))
    told = [one.residual_error for one in found if not math.isnan(one.residual_error)]
    assert told == sorted(told)
    assert all(math.isnan(one.residual_error) for one in found[len(told) :])


def test_without_headings_spins_tell_no_wheelbase():
    found = straights_and_spins(TRUCK, Space(14.0, 4.0, 160.0))
    assert "wheelbase" in {one.name for one in found.held}


@pytest.mark.parametrize("turns", [1, -3])
def test_the_bound_of_a_spin_is_that_of_the_formula(turns):
    """Heading scatters by q sqrt(2 way)/b over a turn of 2 way/b: q / sqrt(2 way), and E_s on top."""
    space = Space(4.0, 4.0, 10.0, 1e-6)
    way = math.pi * 0.34 * abs(turns)
    found = assess("spin", TRUCK, space, [counted_spin(TRUCK, turns), open_straight(TRUCK, 14.0)])
    assert found.sigma[0] == pytest.approx(
        math.hypot(space.roughness / math.sqrt(2.0 * way), found.sigma[1]), rel=0.01
    )


def test_more_way_tells_more():
    short, long = (
        assess(
            "x",
            TRUCK,
            Space(4.0, 4.0, 1.0, SONAR_HEADING_SIGMA),
            [square(TRUCK, 4.0, sign) for sign in (-1, 1)] * count,
        )
        for count in (1, 4)
    )
    np.testing.assert_allclose(long.sigma[[0, 2]] * 2.0, short.sigma[[0, 2]], rtol=1e-6)


def test_a_square_and_a_free_lap_come_home():
    drives = [
        square(TRUCK, 4.0, 1),
        square(TRUCK, 4.0, -1),
        free_lap(TRUCK, 6.0, 4.0, np.random.default_rng(0)),
    ]
    for planned in drives:
        drive = planned.measured(np.zeros(3), "test")
        path = integrate(Differential(TRUCK).steps(drive.readings, np.zeros(3)).increment)
        np.testing.assert_allclose(path[-1, :2], 0.0, atol=1e-9)
        assert math.remainder(path[-1, 2], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_the_bound_before_is_the_confidence_after():
    """What the designer states for six squares, a calibration of a simulated recording attains."""
    robot = reference_single()
    drives = [square(TRUCK, 4.0, sign) for sign in (-1, 1)] * 3
    before = assess("squares", TRUCK, Space(4.0, 4.0, 96.0, SONAR_HEADING_SIGMA), drives)
    true = with_errors(robot, {"a": 336.17 / 340.0}, {"a": 1.00084})
    for seed in range(4):
        after = calibrate_truck([simulate(robot, Truth(true, seed=seed), umbmark(4.0, 3))]).estimate
        rough = next(one.value for one in after.noises if one.source.name == "roughness")
        scaled = after.sigma * CONCRETE_ROUGHNESS / rough  # each recording estimates the roughness for itself
        np.testing.assert_allclose(scaled[[0, 2]], before.sigma[[0, 2]], rtol=0.15)


@pytest.mark.parametrize("values", [(0.0, 4.0, 160.0), (4.0, math.nan, 160.0), (4.0, 4.0, -1.0)])
def test_a_space_that_is_none_is_refused(values):
    with pytest.raises(CalibrationError, match="expected a positive number"):
        Space(*values)
