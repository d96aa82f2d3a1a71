"""Covariances of the nonsystematic error."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.roughness import Roughness, arc_covariance, path_covariance, square_covariance
from studies.papers.trials import Trial, floor_covariance

BASE = 0.34
UNEVEN = Roughness(1e-3, 2e-3)
TRAVEL = st.floats(-2.0, 2.0)


@pytest.mark.parametrize("wheels", [(1.0, 1.0), (-0.3, 0.3), (0.5, 1.0), (-1.0, -1.0), (0.0, 0.6)])
def test_wheels_that_scatter_step_by_step_show_the_closed_form(wheels: tuple[float, float]) -> None:
    """Straight, on the spot, an arc, reverse, and about one wheel: 10 000 drives of 100 rough steps."""
    chance, steps = np.random.default_rng(1), 100
    travel = [
        side / steps + chance.normal(0.0, k * math.sqrt(abs(side) / steps), (10_000, steps))
        for side, k in zip(wheels, (UNEVEN.left, UNEVEN.right), strict=True)
    ]
    turn, way = (travel[1] - travel[0]) / BASE, 0.5 * (travel[0] + travel[1])
    heading = np.cumsum(turn, axis=1) - 0.5 * turn
    ends = [(way * np.cos(heading)).sum(axis=1), (way * np.sin(heading)).sum(axis=1), turn.sum(axis=1)]
    found, wanted = np.cov(ends), arc_covariance(*wheels, BASE, UNEVEN)
    unit = np.sqrt(np.diag(wanted)) + 1e-12
    assert found / np.outer(unit, unit) == pytest.approx(wanted / np.outer(unit, unit), abs=0.06)


def test_a_straight_is_that_of_the_paper() -> None:
    """sigma_theta^2 = k^2 L 2 / b^2, sigma_y^2 = L^2 / 3 of it, their covariance L / 2 of it."""
    covariance = arc_covariance(3.0, 3.0, BASE, Roughness(1e-3, 1e-3))
    heading = 2.0 * 1e-6 * 3.0 / BASE**2
    assert np.diag(covariance) == pytest.approx([0.5e-6 * 3.0, heading * 3.0, heading])
    assert covariance[1, 2] == pytest.approx(1.5 * heading)
    assert covariance[0, 1:] == pytest.approx([0.0, 0.0])


@given(TRAVEL, TRAVEL)
def test_two_halves_make_a_whole(left: float, right: float) -> None:
    """An arc in one piece and in three, carried along, have the same covariance."""
    whole = path_covariance([(left, right)], BASE, UNEVEN)
    parts = path_covariance(
        [(0.2 * left, 0.2 * right), (0.3 * left, 0.3 * right), (0.5 * left, 0.5 * right)], BASE, UNEVEN
    )
    assert parts == pytest.approx(whole, rel=1e-4, abs=1e-12)


@given(TRAVEL, TRAVEL)
def test_it_is_a_covariance(left: float, right: float) -> None:
    """Symmetric, and no direction has a negative variance."""
    covariance = arc_covariance(left, right, BASE, UNEVEN)
    assert covariance == pytest.approx(covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_the_square_of_the_paper_scatters_by_25_mm_on_concrete() -> None:
    """0.56 mm/sqrt(m) make 25 mm in x and in y, and 0.55 degrees; cw is the mirror image of ccw."""
    concrete = Roughness(5.6e-4, 5.6e-4)
    ccw = square_covariance(4.0, BASE, concrete)
    assert np.sqrt(np.diag(ccw)) == pytest.approx([0.025, 0.025, math.radians(0.55)], rel=0.01)
    mirror = np.diag([1.0, -1.0, -1.0])
    assert square_covariance(4.0, BASE, concrete, -1.0) == pytest.approx(mirror @ ccw @ mirror)


def test_the_runs_tell_the_roughness_of_their_floor() -> None:
    """From many runs exactly; the fixes' own scatter is taken off; from 5 + 5 it lies within its limits."""
    many = Trial(0.99, 1.001, floor_covariance(0.025) + np.diag([8e-4, 8e-4, 0.0]), runs=2000)
    errors = many.drive(np.random.default_rng(2)).errors
    assert floor_roughness(errors, BASE, fix_sigma=0.02).value == pytest.approx(5.6e-4, rel=0.04)
    chance, held = np.random.default_rng(3), []
    for _ in range(200):
        one = floor_roughness(Trial(0.99, 1.001, floor_covariance(0.02503)).drive(chance).errors, BASE)
        held.append(one.low <= 5.6e-4 <= one.high)
    assert np.mean(held) > 0.92
