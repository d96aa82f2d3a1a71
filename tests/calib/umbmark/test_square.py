"""The square in closed form, and the fit of its factors to many squares at once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.calib.apply import corrected_truck
from omnimate.calib.umbmark.square import SIGNS, factor_scales, fit_factors, square_ends, weights_of
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Truck

LOG = st.floats(-0.1, 0.1)
SMALL_LOG = st.floats(-0.02, 0.02)
DIAMETER = st.floats(0.14, 0.16)
TRUCK = Truck(0.34, 0.15, 0.151)
PLACES = np.array([[1.0, 1.0, 0.0]] * 2)


@given(LOG, SMALL_LOG, DIAMETER)
def test_eight_arcs_one_by_one_end_at_the_same_place(log_b: float, log_d: float, right: float) -> None:
    """The closed form is the dead reckoning of four legs and four corners, also from unequal wheels."""
    believed = Truck(0.34, 0.15, right)
    actual = corrected_truck(believed, np.exp(log_b), np.exp(log_d))
    ends = square_ends(believed, 4.0, factor_scales(believed, np.array([log_b, log_d])))
    corner = 0.25 * np.pi * believed.wheelbase
    for end, sign in zip(ends, SIGNS, strict=True):
        left = actual.wheel_diameter_left / 0.15 * np.tile([4.0, -sign * corner], 4)
        far = actual.wheel_diameter_right / right * np.tile([4.0, sign * corner], 4)
        driven = integrate(arc(left, far, actual.wheelbase))[-1] - [0.0, 0.0, sign * 2.0 * np.pi]
        assert end == pytest.approx(driven, abs=1e-11)


def test_truths_come_back_from_far_away() -> None:
    """Noise-free, thousands of wild robots (E_b to 10 %, E_d to 2 %) are found to rounding from zero."""
    truths = np.random.default_rng(1).uniform([-0.1, -0.02], [0.1, 0.02], (2000, 2))
    centres = square_ends(TRUCK, 4.0, factor_scales(TRUCK, truths))
    logs, converged = fit_factors(centres, PLACES, TRUCK, 4.0)
    assert converged.all()
    assert np.abs(logs - truths).max() < 1e-12


def test_the_fit_is_the_least() -> None:
    """With scatter, no neighbour fits better."""
    chance = np.random.default_rng(2)
    centres = square_ends(TRUCK, 4.0, factor_scales(TRUCK, np.array([-0.02, 0.001])))
    centres = centres + chance.normal(0.0, 0.02, (50, 2, 3))
    weights = np.array([[1.0, 1.0, 2.0]] * 2)
    logs, converged = fit_factors(centres, weights, TRUCK, 4.0)
    assert converged.all()

    def cost(at: np.ndarray) -> np.ndarray:
        ends = square_ends(TRUCK, 4.0, factor_scales(TRUCK, at))
        return np.sum((weights * (ends - centres)) ** 2, axis=(-1, -2))

    for nudge in (1e-5, 0.0), (-1e-5, 0.0), (0.0, 1e-6), (0.0, -1e-6):
        assert (cost(logs + nudge) > cost(logs)).all()


def test_what_has_no_weight_does_not_count() -> None:
    """Not even where it is not a number; and a start beside the solution changes nothing."""
    centres = square_ends(TRUCK, 4.0, factor_scales(TRUCK, np.array([-0.02, 0.001])))
    blind = centres * [1.0, 1.0, np.nan]
    logs, _ = fit_factors(blind, PLACES, TRUCK, 4.0)
    assert logs == pytest.approx([-0.02, 0.001], abs=1e-12)
    other, _ = fit_factors(blind, PLACES, TRUCK, 4.0, (0.05, -0.01))
    assert other == pytest.approx(logs, abs=1e-11)


def test_weights_grow_with_the_runs_and_stay_finite() -> None:
    """Four times as many runs weigh twice as much; runs without scatter do not weigh infinitely."""
    weights = weights_of(np.array([0.02, 0.02, 0.0]), (4, 1), 4.0)
    assert weights[0, 0] == pytest.approx(100.0)
    assert weights[0] == pytest.approx(2.0 * weights[1])
    assert np.isfinite(weights).all()
