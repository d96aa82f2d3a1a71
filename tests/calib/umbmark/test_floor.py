"""The floor's roughness from the scatter of return positions."""

import math

import numpy as np
import pytest

from omnimate.calib.umbmark.floor import floor_roughness, square_covariance
from studies.papers.trials import Trial, floor_covariance

BASE = 0.34


def test_the_square_of_the_paper_scatters_by_25_mm_on_concrete() -> None:
    """0.56 mm/sqrt(m) make 25 mm in x and in y, and 0.55 degrees; cw is the mirror image of ccw."""
    ccw = square_covariance(4.0, BASE)
    assert 5.6e-4 * np.sqrt(np.diag(ccw)) == pytest.approx([0.025, 0.025, math.radians(0.55)], rel=0.01)
    mirror = np.diag([1.0, -1.0, -1.0])
    assert square_covariance(4.0, BASE, -1.0) == pytest.approx(mirror @ ccw @ mirror)


def test_the_runs_tell_the_roughness_of_their_floor() -> None:
    """From many runs exactly; from 5 + 5 it lies within its limits."""
    many = Trial(0.99, 1.001, floor_covariance(0.025), runs=2000).drive(np.random.default_rng(2))
    assert floor_roughness(many.errors, BASE).value == pytest.approx(5.6e-4, rel=0.04)
    chance, held = np.random.default_rng(3), []
    for _ in range(200):
        one = floor_roughness(Trial(0.99, 1.001, floor_covariance(0.02503)).drive(chance).errors, BASE)
        held.append(one.low <= 5.6e-4 <= one.high)
    assert np.mean(held) > 0.92
