"""A number of a wheel that is said to be wrong was wrong all the time, or it is not what is wrong."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.mismatch.answer.constancy import LEAST, changing_error
from omnimate.mismatch.candidates.nuisances import MODES, drift_waves
from omnimate.mismatch.candidates.terms import term

WHEELS = 4
CERTAIN = 1e3  # readings tell the size of each nuisance to a thousandth


def fit(*sizes, ratio=1.003, wheel="a.right"):
    """A fit of one wheel's diameter, whose slow change has these sizes, in standard deviations."""
    diameter = term("wheel_diameter", wheel)
    nuisance = CERTAIN * np.eye(WHEELS * MODES)
    drift = np.zeros(WHEELS * MODES)
    drift[MODES : 2 * MODES] = sizes
    block = SimpleNamespace(travel=np.full((10, WHEELS), 0.01))
    regression = SimpleNamespace(
        white=(nuisance @ drift)[:, None], windows=[SimpleNamespace(signals=SimpleNamespace(block=block))]
    )
    effect = diameter.built(np.array([(ratio - 1.0) / diameter.probes[0].parameters[0].scale]))
    chosen = SimpleNamespace(terms=(diameter,), effects=(effect,))
    return SimpleNamespace(chosen=chosen, nuisance=nuisance, regression=regression)


def test_a_wheel_that_had_its_nominal_size_at_the_beginning_has_no_constant_error():
    error = changing_error(fit(-4.0, -1.0, -1.0), 0)
    assert error.begin == pytest.approx(0.0, abs=1e-5)
    assert error.end == pytest.approx(0.005, abs=1e-5)


def test_a_wheel_that_became_nominal_has_none_either():
    assert changing_error(fit(4.0, 0.0, 1.0, ratio=0.997), 0).begin == pytest.approx(-0.0005, abs=1e-5)


def test_a_usual_change_leaves_even_a_small_constant_error_its_name():
    assert changing_error(fit(-1.0, 0.0, 0.0, ratio=1.0004), 0) is None


@given(st.lists(st.floats(-6.0, 6.0), min_size=MODES, max_size=MODES), st.floats(1.002, 1.02))
def test_an_error_that_is_there_all_the_time_keeps_its_name(sizes, ratio):
    error = ratio - 1.0 + drift_waves(200) @ sizes
    if error.min() > LEAST * (ratio - 1.0):
        assert changing_error(fit(*sizes, ratio=ratio), 0) is None


def test_the_change_of_another_wheel_says_nothing():
    assert changing_error(fit(-4.0, -1.0, -1.0, wheel="b.left"), 0) is None
