"""A reading in steps cuts off what lies outside of its step, and says nothing where nothing does."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from omnimate.ipec.filter.measurement import truncate_normal


def moments(offset, variance, half):
    """Return mean and variance within the step by brute force."""
    x = np.linspace(offset - half, offset + half, 20_001)
    weight = np.exp(-0.5 * x * x / variance)
    mean = np.average(x, weights=weight)
    return mean, np.average((x - mean) ** 2, weights=weight)


@given(st.floats(-3.0, 3.0), st.floats(0.2, 3.0), st.floats(0.05, 2.0))
def test_mean_and_variance_of_what_remains(offset, sigma, half):
    assume((abs(offset) - half) / sigma < 4.0)
    push, information = truncate_normal(offset, sigma**2, half)
    if information == 0.0:
        assert push == 0.0
        return
    mean, variance = moments(offset, sigma**2, half)
    assert push * sigma**2 == pytest.approx(mean, abs=1e-3)
    assert sigma**2 - information * sigma**4 == pytest.approx(variance, abs=1e-3)


def test_what_lies_inside_says_nothing_new():
    assert truncate_normal(0.0, 1.0, 2.0) == (0.0, 0.0)


def test_repeating_a_reading_does_not_average_its_resolution_away():
    """A thousand equal readings leave the deviation of the step, half / sqrt(3), not a thirtieth of it."""
    variance = 1.0
    for _ in range(1000):
        _, information = truncate_normal(0.0, variance, 0.5)
        variance -= information * variance**2
    assert np.sqrt(variance) == pytest.approx(0.5 / np.sqrt(3.0), rel=0.1)


def test_far_outside_the_centre_of_the_step_is_taken():
    push, information = truncate_normal(20.0, 1.0, 0.5)
    assert push == pytest.approx(20.0 / (1.0 + 0.25 / 3.0))
    assert information == pytest.approx(1.0 / (1.0 + 0.25 / 3.0))
