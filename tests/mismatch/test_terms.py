"""Candidates as columns: what bends is tried at several sizes."""

import numpy as np
import pytest

from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.terms import smooth_terms, term
from omnimate.mismatch.windows import windows_of
from omnimate.vcan_sim.effects import effect_named


@pytest.fixture(scope="module")
def signals(drive):
    return signals_of(drive(laps=1))


@pytest.fixture(scope="module")
def shown(signals):
    """Return a function from terms to the unwhitened columns of what the linkage shows, `(C, M + 1, 3)`."""

    def columns(*terms):
        windows = [windows_of(signals)]
        regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
        regression.add(terms)
        return regression.raw[0][1][:, :3, 1:].transpose(2, 0, 1)

    return columns


def test_a_wide_play_is_met_by_the_column_of_its_own_size(shown):
    scale = effect_named("joint_backlash").parameters[0].scale
    narrow, wide = (term("joint_backlash", "joint_b", size=size) for size in (1.0, 8.0))
    truth = shown(narrow, wide)[1] * 8.0
    np.testing.assert_allclose(np.ptp(truth[:, 1]), np.ptp(shown(narrow)[0] * 8.0), rtol=0.2)
    assert np.std(truth - 8.0 * shown(narrow)[0]) > 0.05 * 8.0 * scale
    assert wide.built(np.array([8.0])).width == pytest.approx(8.0 * scale)


def test_what_does_not_bend_has_the_same_column_at_every_size(shown):
    one, other = shown(term("joint_bias", "joint_a"), term("joint_bias", "joint_a", size=5.0))
    np.testing.assert_allclose(one, other, atol=1e-9)


def test_a_fit_starts_at_the_size_found_and_takes_slopes_there():
    wide = term("joint_backlash", "joint_b", 3, 8.0)
    fine = wide.fine()
    assert fine.size == 1.0
    assert fine.plausibility == wide.plausibility
    assert fine.fine() is fine


def test_only_one_size_of_an_effect_is_tolerated_in_every_robot(signals):
    own = [one for one in smooth_terms([signals]) if one.key == ("latency", "a.left")]
    assert len(own) > 1
    assert sum(one.tolerance > 0.0 for one in own) == 1


def test_a_law_is_no_candidate(signals):
    assert not [one for one in smooth_terms([signals]) if one.effect == "law"]
