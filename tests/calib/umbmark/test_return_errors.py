"""Return errors: their summary, and the guard against swapped directions."""

import math

import numpy as np
import pytest

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError, DirectionError
from omnimate.calib.umbmark.exact import square_returns
from omnimate.calib.umbmark.return_errors import MIRROR, ReturnErrors, check_directions
from omnimate.vehicle.parameters import Truck
from studies.papers.trials import Trial, floor_covariance

TRUCK = Truck(0.34, 0.15, 0.15)


def noisy(e_b: float, e_d: float, seed: int, runs: int = 5, sigma: float = 0.025) -> ReturnErrors:
    rng = np.random.default_rng(seed)
    chain = square_returns(TRUCK, corrected_truck(TRUCK, e_b, e_d), 4.0)
    cw, ccw = (end + rng.normal(0.0, sigma, (runs, 3)) for end in chain)
    return ReturnErrors(cw, ccw, 4.0)


def swapped(errors: ReturnErrors) -> ReturnErrors:
    return ReturnErrors(errors.ccw.copy(), errors.cw.copy(), errors.side)


def test_summary() -> None:
    """Centres of gravity, distances and E_max,syst are those of (3.2)-(3.4)."""
    errors = ReturnErrors(np.array([[0.1, 0.0, 0.0], [0.5, 0.8, 0.2]]), np.array([[-0.06, 0.08, 0.0]]), 4.0)
    assert errors.centres == pytest.approx(np.array([[0.3, 0.4, 0.1], [-0.06, 0.08, 0.0]]))
    assert errors.radii == pytest.approx([0.5, 0.1])
    assert errors.e_max_syst == pytest.approx(0.5)
    assert errors.worst == pytest.approx(math.hypot(0.5, 0.8))


def test_standard_error_of_the_paper() -> None:
    """25 mm of scatter in 5 + 5 runs are 11.2 mm of SEM, and 3 SEM are 33.5 mm."""
    spread = (
        0.025 * math.sqrt(4.0 / 10.0) * np.array([[-2, 0, 0], [-1, 1, 0], [0, -2, 0], [1, 2, 0], [2, -1, 0]])
    )
    errors = ReturnErrors(spread + np.array([0.3, 0.3, 0.0]), spread - np.array([0.02, -0.02, 0.0]), 4.0)
    assert errors.scatter == pytest.approx(0.025)
    assert 1e3 * errors.sem == pytest.approx(11.2, abs=0.05)
    assert errors.second_pass_helps is True
    calm = ReturnErrors(spread + np.array([0.02, 0.02, 0.0]), spread.copy(), 4.0)
    assert calm.second_pass_helps is False


def test_one_run_each_way_has_no_standard_error() -> None:
    """With n = 1 the scatter is unknown and the stop rule says so."""
    errors = noisy(0.98, 1.001, seed=1, runs=1)
    assert math.isnan(errors.sem)
    assert np.isnan(errors.covariance).all()
    assert errors.second_pass_helps is None


@pytest.mark.parametrize(("cw", "ccw", "missing"), [(0, 3, "no cw"), (3, 0, "no ccw")])
def test_a_missing_direction_is_an_error(cw: int, ccw: int, missing: str) -> None:
    """One direction alone cannot tell the two parameters apart."""
    with pytest.raises(DirectionError, match=missing):
        ReturnErrors(np.zeros((cw, 3)), np.zeros((ccw, 3)), 4.0)


def test_positions_and_sides_must_be_numbers() -> None:
    """NaN positions, and sides that are no length, are refused; an unknown heading is not."""
    ReturnErrors(np.array([[0.0, 0.0, np.nan]]), np.zeros((1, 3)), 4.0)
    with pytest.raises(CalibrationError, match="not a number"):
        ReturnErrors(np.array([[np.nan, 0.0, 0.0]]), np.zeros((1, 3)), 4.0)
    with pytest.raises(CalibrationError, match="side"):
        ReturnErrors(np.zeros((1, 3)), np.zeros((1, 3)), math.nan)


@pytest.mark.parametrize(
    "factors", [(0.98874, 1.00084), (1.0, 1.001), (1.01, 1.0), (0.95, 1.005), (0.90, 1.02)]
)
def test_swapped_directions_are_seen(factors: tuple[float, float]) -> None:
    """As driven they pass; exchanged they are refused, unless beyond what diagonals can say."""
    errors = noisy(*factors, seed=2)
    check_directions(errors)
    if factors != (0.90, 1.02):
        with pytest.raises(DirectionError, match="swapped"):
            check_directions(swapped(errors))


def test_y_to_the_right_is_seen() -> None:
    """A table with y measured to the right looks the same, and the sentence says so."""
    errors = noisy(0.98874, 1.00084, seed=3)
    mirrored = ReturnErrors(errors.cw * [1, -1, 1], errors.ccw * [1, -1, 1], 4.0)
    with pytest.raises(DirectionError, match="right"):
        check_directions(mirrored)


def test_a_calibrated_robot_raises_no_false_alarm() -> None:
    """Clusters around the origin lie anywhere; of 500 such tables none is refused."""
    for seed in range(500):
        check_directions(noisy(1.0, 1.0, seed=seed))


def test_mirrored_runs_pool_their_correlations() -> None:
    """Many runs in both directions show the covariance that they were drawn from, with its signs."""
    wanted = floor_covariance(0.025)
    errors = Trial(0.99, 1.001, wanted, runs=4000).drive(np.random.default_rng(3)).errors
    unit = np.sqrt(np.diag(wanted))
    assert errors.freedom == 7998
    assert errors.covariance / np.outer(unit, unit) == pytest.approx(wanted / np.outer(unit, unit), abs=0.06)
    of_centres = errors.covariance_of_centres
    assert of_centres[:3, :3] * 4000 == pytest.approx(np.outer(MIRROR, MIRROR) * errors.covariance)
    assert not of_centres[:3, 3:].any()
