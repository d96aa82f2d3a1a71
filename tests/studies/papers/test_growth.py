"""The growth rates of C 3.3, driven: the heading errs at once, the side by 0.15 mm an interval."""

import math

import numpy as np
import pytest

from studies.papers.bumps import bump_growth


def test_plain_odometry_errs_by_0_44_degrees_at_once_and_0_15_mm_in_each_interval():
    growth = bump_growth()
    assert np.degrees(-growth.plain[1:, 0]) == pytest.approx(0.443, abs=0.002)
    assert -1e3 * np.diff(growth.plain[2:, 1]) == pytest.approx(0.155, abs=0.005)


def test_the_linkage_sees_at_least_what_the_paper_bounds_and_the_rest_stays():
    growth = bump_growth()
    assert math.degrees(-growth.seen[1]) == pytest.approx(math.degrees(growth.printed.measured), abs=0.01)
    assert np.abs(growth.ipec[:, 0]).max() < math.radians(0.01)
    assert np.abs(growth.ipec[:, 1]).max() < 0.2e-3
