"""What the encoders say of the size of all wheels at once is left to poses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.mixture import discard_common_scale
from omnimate.ipec.filter.records import SLOW

WHEELS = np.array([1.0] * 4 + [0.0] * (SLOW - 4))


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), variance=st.floats(1e-3, 1e3))
def test_the_size_of_all_wheels_is_as_uncertain_as_with_a_nuisance_along_it(seed, variance):
    """The covariance grows by the variance along the four wheels, and the mean stays."""
    chance = np.random.default_rng(seed)
    root = chance.normal(size=(SLOW, SLOW))
    told, mean = root @ root.T + np.eye(SLOW), chance.normal(size=SLOW)
    pull, covariance = told @ mean, np.linalg.inv(told)
    discard_common_scale(told, pull, variance)
    assert np.linalg.inv(told) == pytest.approx(
        covariance + variance * np.outer(WHEELS, WHEELS), rel=1e-6, abs=1e-6 * (1.0 + variance)
    )
    assert np.linalg.solve(told, pull) == pytest.approx(mean, rel=1e-5, abs=1e-5)
