"""Effects as they fit best, and what of the data they explain."""

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.fit import fitted
from omnimate.mismatch.recording.signals import signals_of
from tests.mismatch.conftest import USUAL


def fit_of(recording, single, value):
    return fitted([signals_of(recording)], USUAL, [single], [np.array([value])], turns=0)


def test_what_a_linear_effect_explains_is_its_column_times_its_size(drive):
    fit = fit_of(drive(laps=1), term("wheel_diameter", "a.left"), 0.2)
    column = fit.regression.white[:, fit.chosen.places[0].start]
    np.testing.assert_allclose(fit.part, 0.2 * column, atol=0.02 * np.abs(0.2 * column).max())


@pytest.mark.parametrize("component", ["link", "joint_b"])
def test_data_with_what_a_delay_explains_is_no_noisier_for_the_delay(drive, component):
    """The column of a delay holds what wheels round off; added to the data, it would explain itself."""
    recording = drive(laps=1)
    healthy, delayed = (fit_of(recording, term("latency", component), delay) for delay in (0.0, 2.0))
    plain = healthy.regression.white[:, 0] + healthy.part
    whole = delayed.regression.white[:, 0] + delayed.part
    assert whole @ whole == pytest.approx(plain @ plain, rel=1e-3)
