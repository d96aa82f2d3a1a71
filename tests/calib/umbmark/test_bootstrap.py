"""Ten thousand resamples."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.bootstrap import RESAMPLES, bootstrap
from omnimate.calib.umbmark.experiment import METHODS, calibrate
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from studies.papers.trials import Trial, floor_covariance

FLOOR = Trial(0.98874, 1.00084, floor_covariance(0.025))


@pytest.mark.parametrize("method", METHODS)
def test_it_agrees_with_the_delta_method(method: str) -> None:
    """At errors of this size the chain is nearly straight, and both intervals are alike."""
    calibration = calibrate(FLOOR.drive(np.random.default_rng(1)), method)  # type: ignore[arg-type]  # the words
    drawn, known = bootstrap(calibration), uncertainty_of(calibration)
    assert drawn.factors.shape == (RESAMPLES, 2)
    assert drawn.uncertainty.e_b.half == pytest.approx(known.e_b.half, rel=0.3)
    assert drawn.uncertainty.e_d.half == pytest.approx(known.e_d.half, rel=0.3)


@pytest.mark.parametrize("method", ["exact", "weighted"])
def test_its_intervals_hold_the_truth_in_about_95_per_cent(method: str) -> None:
    """Counted over 150 experiments of 5 + 5 runs, each with 500 resamples."""
    chance = np.random.default_rng(2)
    held = []
    for seed in range(150):
        calibration = calibrate(FLOOR.drive(chance), method)  # type: ignore[arg-type]  # the words
        one = bootstrap(calibration, resamples=500, seed=seed).uncertainty
        held.append((one.e_b.low <= 0.98874 <= one.e_b.high, one.e_d.low <= 1.00084 <= one.e_d.high))
    assert np.mean(held, axis=0) == pytest.approx([0.95, 0.95], abs=0.055)


def test_the_same_seed_draws_the_same() -> None:
    """And another one does not."""
    calibration = calibrate(FLOOR.drive(np.random.default_rng(3)))
    first, again, other = (bootstrap(calibration, resamples=100, seed=seed) for seed in (0, 0, 1))
    assert np.array_equal(first.factors, again.factors)
    assert not np.array_equal(first.factors, other.factors)


def test_two_runs_are_too_few_to_draw_from() -> None:
    """It says how many are needed."""
    with pytest.raises(CalibrationError, match="3 runs"):
        bootstrap(calibrate(replace(FLOOR, runs=2).drive(np.random.default_rng(4))))
