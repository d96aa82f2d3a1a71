"""Newton's method on many squares at once."""

import numpy as np
import pytest

from omnimate.calib.umbmark.square import factor_scales, square_ends
from omnimate.calib.umbmark.square_fit import fit_factors
from omnimate.vehicle.parameters import Truck

TRUCK = Truck(0.34, 0.15, 0.151)
PLACES = np.array([[1.0, 1.0, 0.0]] * 2)


def test_truths_come_back_from_far_away() -> None:
    """Noise-free, thousands of wild robots (E_b to 10 %, E_d to 2 %) are found to rounding from zero."""
    truths = np.random.default_rng(1).uniform([-0.1, -0.02], [0.1, 0.02], (2000, 2))
    centres, _ = square_ends(TRUCK, 4.0, factor_scales(TRUCK, truths)[0])
    logs, converged = fit_factors(centres, PLACES, TRUCK, 4.0)
    assert converged.all()
    assert np.abs(logs - truths).max() < 1e-12


def test_the_fit_is_the_least() -> None:
    """With scatter, no neighbour fits better."""
    chance = np.random.default_rng(2)
    centres = square_ends(TRUCK, 4.0, factor_scales(TRUCK, np.array([-0.02, 0.001]))[0])[0]
    centres = centres + chance.normal(0.0, 0.02, (50, 2, 3))
    weights = np.array([[1.0, 1.0, 2.0]] * 2)
    logs, converged = fit_factors(centres, weights, TRUCK, 4.0)
    assert converged.all()

    def cost(at: np.ndarray) -> np.ndarray:
        ends, _ = square_ends(TRUCK, 4.0, factor_scales(TRUCK, at)[0])
        return np.sum((weights * (ends - centres)) ** 2, axis=(-1, -2))

    for nudge in (1e-5, 0.0), (-1e-5, 0.0), (0.0, 1e-6), (0.0, -1e-6):
        assert (cost(logs + nudge) > cost(logs)).all()


def test_what_has_no_weight_does_not_count() -> None:
    """Not even where it is not a number; and a start beside the solution changes nothing."""
    centres = square_ends(TRUCK, 4.0, factor_scales(TRUCK, np.array([-0.02, 0.001]))[0])[0]
    blind = centres * [1.0, 1.0, np.nan]
    logs, _ = fit_factors(blind, PLACES, TRUCK, 4.0)
    assert logs == pytest.approx([-0.02, 0.001], abs=1e-12)
    other, _ = fit_factors(blind, PLACES, TRUCK, 4.0, (0.05, -0.01))
    assert other == pytest.approx(logs, abs=1e-11)
