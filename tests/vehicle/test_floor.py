"""How a rough floor scatters odometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.floor import path_covariance

BASE = 0.34
TRAVEL = st.floats(-2.0, 2.0)


@pytest.mark.parametrize("wheels", [(1.0, 1.0), (-0.3, 0.3), (0.5, 1.0), (-1.0, -1.0), (0.0, 0.6)])
def test_wheels_that_scatter_step_by_step_show_the_covariance(wheels):
    """Straight, on the spot, an arc, reverse, and about one wheel: 10 000 drives of 100 rough steps."""
    chance, steps, rough = np.random.default_rng(1), 100, 1e-3
    travel = [
        side / steps + chance.normal(0.0, rough * math.sqrt(abs(side) / steps), (10_000, steps))
        for side in wheels
    ]
    turn, way = (travel[1] - travel[0]) / BASE, 0.5 * (travel[0] + travel[1])
    heading = np.cumsum(turn, axis=1) - 0.5 * turn
    ends = [(way * np.cos(heading)).sum(axis=1), (way * np.sin(heading)).sum(axis=1), turn.sum(axis=1)]
    found, wanted = np.cov(ends), rough**2 * path_covariance([wheels[0]], [wheels[1]], BASE)
    unit = np.sqrt(np.diag(wanted)) + 1e-12
    assert found / np.outer(unit, unit) == pytest.approx(wanted / np.outer(unit, unit), abs=0.06)


def test_a_straight_is_that_of_the_paper():
    """sigma_theta^2 = k^2 L 2 / b^2, sigma_y^2 = L^2 / 3 of it, their covariance L / 2 of it."""
    covariance = path_covariance([3.0], [3.0], BASE)
    heading = 2.0 * 3.0 / BASE**2
    assert np.diag(covariance) == pytest.approx([0.5 * 3.0, heading * 3.0, heading])
    assert covariance[1, 2] == pytest.approx(1.5 * heading)
    assert covariance[0, 1:] == pytest.approx([0.0, 0.0])


@given(TRAVEL, TRAVEL)
def test_an_arc_in_one_piece_and_in_three_scatters_alike(left, right):
    whole, parts = path_covariance([left], [right], BASE), np.array([0.2, 0.3, 0.5])
    assert path_covariance(parts * left, parts * right, BASE) == pytest.approx(whole, rel=1e-9, abs=1e-9)
    assert np.linalg.eigvalsh(whole).min() > -1e-9
