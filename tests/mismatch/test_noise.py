"""The levels of noise, estimated from the recordings themselves."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.noise import DEFAULT_LEVELS, estimate_noise
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of


@pytest.fixture(scope="module")
def healthy(drive):
    return [windows_of(signals_of(drive()))]


def left(windows, noise):
    """Return the chi-square that levels leave for each row."""
    white = Regression(windows, noise, (), folds_of(windows)).white[:, 0]
    return float(white @ white) / len(white)


def test_the_levels_make_what_is_left_as_large_as_they_say(healthy):
    raw = Regression(healthy, DEFAULT_LEVELS, (), folds_of(healthy)).raw
    assert left(healthy, estimate_noise(healthy, raw)) == pytest.approx(1.0, abs=0.1)


def test_a_search_that_begins_where_readings_do_not_err_comes_back(healthy):
    raw = Regression(healthy, DEFAULT_LEVELS, (), folds_of(healthy)).raw
    trapped = replace(DEFAULT_LEVELS, joint_a=1e-9, joint_b=1e-9, link=1e-9)
    found, usual = estimate_noise(healthy, raw, trapped), estimate_noise(healthy, raw)
    assert left(healthy, found) == pytest.approx(1.0, abs=0.1)
    np.testing.assert_allclose(
        found.levels()[[4, 5, 6]], usual.levels()[[4, 5, 6]], atol=1.0
    )  # of the readings: within a factor of e
