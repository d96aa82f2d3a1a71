"""The exact corner chain and its inversion."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.printed import solve_printed
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.vehicle.parameters import Truck

ANGLE = st.floats(-0.2, 0.2)
SIDE = st.sampled_from([0.5, 0.75, 2.0, 4.0, 10.0])
WHEELBASE = st.sampled_from([0.2, 0.34, 0.6])


def factors(alpha: float, beta: float, side: float, wheelbase: float) -> tuple[float, float]:
    """Return E_b and E_d that cause alpha and beta [rad], with the legs as exact arcs."""
    e_b = 0.5 * math.pi / (0.5 * math.pi - alpha)
    half = 0.5 * beta * wheelbase * e_b / side
    return e_b, (1.0 + half) / (1.0 - half)


def errors_of(chain: np.ndarray, side: float) -> ReturnErrors:
    return ReturnErrors(chain[:1].copy(), chain[1:].copy(), side)


@given(ANGLE, ANGLE, SIDE, WHEELBASE)
def test_inversion_returns_the_truth(alpha: float, beta: float, side: float, wheelbase: float) -> None:
    """Noise-free, the inversion gives E_b and E_d at once, to 1e-9, far beyond small angles."""
    truck = Truck(wheelbase, 0.15, 0.15)
    e_b, e_d = factors(alpha, beta, side, wheelbase)
    chain = square_returns(truck, corrected_truck(truck, e_b, e_d), side)
    correction = solve_exact(errors_of(chain, side), truck)
    assert correction.e_b == pytest.approx(e_b, abs=1e-9)
    assert correction.e_d == pytest.approx(e_d, abs=1e-9)
    assert correction.alpha == pytest.approx(alpha, abs=1e-8)
    assert correction.beta == pytest.approx(beta, abs=1e-6)


@given(ANGLE, ANGLE, SIDE, WHEELBASE)
def test_headings_alone_tell_the_angles(alpha: float, beta: float, side: float, wheelbase: float) -> None:
    """alpha = (th_cw - th_ccw) / 8 and beta = (th_cw + th_ccw) / 8 hold exactly."""
    truck = Truck(wheelbase, 0.15, 0.15)
    chain = square_returns(truck, corrected_truck(truck, *factors(alpha, beta, side, wheelbase)), side)
    cw, ccw = chain[:, 2]
    assert (cw - ccw) / 8.0 == pytest.approx(alpha, abs=1e-9)
    assert (cw + ccw) / 8.0 == pytest.approx(beta, abs=1e-9)


@given(ANGLE, ANGLE, SIDE, WHEELBASE)
def test_mirror_symmetry(alpha: float, beta: float, side: float, wheelbase: float) -> None:
    """Swapping the wheels swaps cw and ccw and turns y and theta round."""
    truck = Truck(wheelbase, 0.15, 0.15)
    e_b, e_d = factors(alpha, beta, side, wheelbase)
    chain = square_returns(truck, corrected_truck(truck, e_b, e_d), side)
    mirrored = square_returns(truck, corrected_truck(truck, e_b, 1.0 / e_d), side)
    assert mirrored[::-1] * [1.0, -1.0, -1.0] == pytest.approx(chain, abs=1e-9)


@pytest.mark.parametrize("direction", [-1.0, 1.0])
def test_legs_are_arcs_and_corners_turns_about_the_displaced_centre(direction: float) -> None:
    """U Fig. 7 to 9: arcs of length L and heading gain beta, corners of 90 - alpha degrees."""
    alpha, beta, side, wheelbase = 0.08, 0.06, 4.0, 0.34
    e_b, e_d = factors(alpha, beta, side, wheelbase)
    truck = Truck(wheelbase, 0.15, 0.15)
    chain = square_returns(truck, corrected_truck(truck, e_b, e_d), side)[0 if direction < 0 else 1]
    radius, shift = (
        side / beta,
        0.5 * wheelbase * e_b * (e_d - 1.0) / (e_d + 1.0),
    )  # ICR of leg; of corner, Fig. 2
    place, heading = 0j, 0.0
    for _ in range(4):
        for bend, turn in ((radius, beta), (shift, direction * (0.5 * math.pi - alpha))):
            place += bend * (cmath.exp(1j * (heading + turn)) - cmath.exp(1j * heading)) / 1j
            heading += turn
    assert chain == pytest.approx([place.real, place.imag, heading - direction * 2.0 * math.pi], abs=1e-12)


def test_a_second_pass_on_unequal_wheels_is_exact() -> None:
    """After a printed first pass the inversion finds what is left, to rounding."""
    nominal = Truck(0.34, 0.15, 0.15)
    actual = corrected_truck(nominal, 0.95, 1.005)
    first = solve_printed(errors_of(square_returns(nominal, actual, 4.0), 4.0), nominal.wheelbase)
    believed = corrected_truck(nominal, first.e_b, first.e_d)
    second = solve_exact(errors_of(square_returns(believed, actual, 4.0), 4.0), believed)
    found = corrected_truck(believed, second.e_b, second.e_d)
    assert found.wheelbase == pytest.approx(actual.wheelbase, abs=1e-11)
    assert found.wheel_diameter_left == pytest.approx(actual.wheel_diameter_left, abs=1e-11)


def test_headings_join_by_their_weight() -> None:
    """Headings with little scatter decide over positions with much; unweighted they do not count."""
    truck = Truck(0.34, 0.15, 0.15)
    chain = square_returns(truck, corrected_truck(truck, 0.99, 1.0), 4.0)
    chain[:, :2] += [[0.05, 0.02], [-0.01, 0.04]]
    scatter = np.array([[1.0, 1.0, 1e-6], [-1.0, -1.0, -1e-6]])
    errors = ReturnErrors(chain[0] + scatter, chain[1] + scatter, 4.0)
    assert solve_exact(errors, truck, "weighted").e_b == pytest.approx(0.99, abs=1e-6)
    without = ReturnErrors(errors.cw * [1, 1, np.nan], errors.ccw * [1, 1, np.nan], 4.0)
    assert solve_exact(without, truck) == solve_exact(errors, truck)
    with pytest.raises(CalibrationError, match="heading"):
        solve_exact(without, truck, "weighted")
    with pytest.raises(CalibrationError, match="no scatter"):
        solve_exact(errors_of(chain, 4.0), truck, "weighted")


def test_more_runs_weigh_more() -> None:
    """Where the clusters contradict each other, the one of more runs is believed more."""
    truck = Truck(0.34, 0.15, 0.15)
    cw, ccw = square_returns(truck, corrected_truck(truck, 0.99, 1.001), 4.0)
    odd = cw + np.array([0.05, -0.05, 0.0])
    few = ReturnErrors(np.tile(odd, (1, 1)), np.tile(ccw, (9, 1)), 4.0)
    many = ReturnErrors(np.tile(odd, (9, 1)), np.tile(ccw, (1, 1)), 4.0)
    residual = [
        np.hypot(*(square_returns(truck, corrected_truck(truck, found.e_b, found.e_d), 4.0)[0] - odd)[:2])
        for found in (solve_exact(few, truck), solve_exact(many, truck))
    ]
    assert residual[1] < residual[0]


def test_errors_that_no_robot_makes_are_refused() -> None:
    """Metres for millimetres: an error with advice, not a wheelbase of a kilometre."""
    wild = ReturnErrors(np.array([[300.0, -200.0, 0.0]]), np.array([[-100.0, 300.0, 0.0]]), 4.0)
    with pytest.raises(CalibrationError, match="units"):
        solve_exact(wild, Truck(0.34, 0.15, 0.15))
