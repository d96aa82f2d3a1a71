"""Confidence intervals hold what they promise."""

import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.umbmark.experiment import calibrate
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from studies.papers.trials import Trial, coverage, floor_covariance, plain_covariance

FLOOR = Trial(0.98874, 1.00084, floor_covariance(0.025))


@pytest.mark.parametrize("method", ["printed", "heading", "exact", "weighted"])
@pytest.mark.parametrize("runs", [2, 5])
def test_intervals_of_95_per_cent_hold_the_truth_in_about_95(method: str, runs: int) -> None:
    """Counted over 300 experiments on a rough floor, with two and with five runs in each direction."""
    held = coverage(replace(FLOOR, runs=runs), 300, method, seed=runs)  # type: ignore[arg-type]  # the words
    assert held == pytest.approx([0.95, 0.95], abs=0.04)


@pytest.mark.parametrize(
    ("factors", "position"), [((0.98874, 1.00084), 0.003), ((0.95, 1.005), 0.022), ((0.90, 1.02), 0.022)]
)
def test_intervals_of_the_printed_equations_hold_their_bias_too(
    factors: tuple[float, float], position: float
) -> None:
    """With little scatter, or with large errors, small angles cost more than the scatter."""
    trial = Trial(*factors, floor_covariance(position))
    assert np.all(coverage(trial, 100, "printed", seed=3) > 0.9)


def test_other_confidences() -> None:
    """Two thirds are two thirds."""
    assert coverage(FLOOR, 300, "printed", 0.67) == pytest.approx([0.67, 0.67], abs=0.08)


def test_sizes_follow_the_factors() -> None:
    """The wheelbase's limits are E_b's times the nominal one; the wheels move against each other."""
    calibration = calibrate(FLOOR.drive(np.random.default_rng(5)))
    known = uncertainty_of(calibration)
    assert known.freedom == 8
    assert known.wheelbase.low == pytest.approx(0.34 * known.e_b.low, rel=1e-12)
    assert known.wheelbase.value == calibration.truck.wheelbase
    assert known.diameter_left.low < calibration.truck.wheel_diameter_left < known.diameter_left.high
    assert known.diameter_left.half == pytest.approx(known.diameter_right.half, rel=1e-2)
    assert known.e_b.half == pytest.approx(2.306 * math.sqrt(known.covariance[0, 0]), rel=1e-3)


def test_more_runs_know_more() -> None:
    """Four times as many runs halve the standard error."""
    few, many = (
        uncertainty_of(calibrate(replace(FLOOR, runs=runs).drive(np.random.default_rng(6))))
        for runs in (50, 200)
    )
    assert many.covariance[0, 0] / few.covariance[0, 0] == pytest.approx(0.25, abs=0.08)


def test_one_run_each_way_knows_nothing() -> None:
    """The limits are not numbers; the value stands."""
    known = uncertainty_of(calibrate(replace(FLOOR, runs=1).drive(np.random.default_rng(7))))
    assert math.isnan(known.e_b.low)
    assert math.isnan(known.wheelbase.half)
    assert known.e_b.value == pytest.approx(0.98874, abs=0.02)


def test_missing_headings_leave_the_intervals_of_positions_alone() -> None:
    """The exact method does not use headings, so that its intervals do not either."""
    experiment = replace(FLOOR, covariance=plain_covariance(0.025)).drive(np.random.default_rng(8))
    errors = experiment.errors
    blind = replace(
        experiment, errors=replace(errors, cw=errors.cw * [1, 1, np.nan], ccw=errors.ccw * [1, 1, np.nan])
    )
    with_headings, without = (uncertainty_of(calibrate(one)) for one in (experiment, blind))
    assert without.e_b.low == pytest.approx(with_headings.e_b.low, rel=1e-9)
    assert without.e_d.high == pytest.approx(with_headings.e_d.high, rel=1e-9)
