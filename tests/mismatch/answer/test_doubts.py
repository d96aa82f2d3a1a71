"""Names are doubted where another law, or an error without a name, may be what they explain."""

from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.mismatch.answer.doubts import EVEN, SUREST, _are_discrepancies, surest_names
from omnimate.mismatch.answer.omnibus import RELEVANT_SQUARE, Leftover, Prediction
from omnimate.mismatch.answer.shares import Share
from omnimate.mismatch.candidates.terms import EVENT_MARGIN, term

STRONG = term("bump", "b.right", times=(10.0, 20.0, 30.0))
MISSED = STRONG.discrepancy**2  # share of a strong event that its law may miss


def doubts(other, share):
    return _are_discrepancies([STRONG, other], [1.0 - share, share])


def bumps(*times):
    return term("bump", "a.right", times=times)


def test_a_weak_event_at_the_moments_of_a_strong_one_is_doubted_and_not_the_reverse():
    assert doubts(bumps(10.1, 20.1, 30.1), 0.5 * MISSED) == [False, True]


def test_a_weak_event_at_other_moments_is_not_doubted():
    later = 2.0 * EVENT_MARGIN
    assert doubts(bumps(10.0 + later, 20.0 + later), 0.1 * MISSED) == [False, False]


def test_two_wheels_that_cross_an_obstacle_are_both_believed():
    assert doubts(bumps(10.0, 20.0, 30.0), 0.4) == [False, False]


@pytest.mark.parametrize(("share", "doubted"), [(0.4, True), (0.6, False)])
def test_a_strong_event_counts_as_far_as_moments_coincide(share, doubted):
    half = bumps(10.1, 15.0)
    assert doubts(half, share * MISSED / (1.0 + share * MISSED)) == [False, doubted]


def test_a_lasting_effect_is_compared_with_all_others():
    lasting = term("link_bias", "link")
    assert doubts(lasting, 0.5 * MISSED) == [False, True]
    assert _are_discrepancies([lasting, bumps(5.0)], [0.99, 1e-6]) == [False, False]


@pytest.mark.parametrize(("component", "share"), [("a", 1.1), ("a", 0.9), ("b", 1.1)])
def test_a_lasting_name_is_doubted_on_the_component_of_what_predicts_a_relevant_share_of_the_rest(
    component, share
):
    rng = np.random.default_rng(1)
    part, other = 10.0 * rng.normal(size=(2, 200))
    shown = Share("a.x", share * RELEVANT_SQUARE)
    left = Leftover(1e-6, (Prediction(component, "time", shown, 50.0, other[:, None]),))
    fit = SimpleNamespace(chosen=SimpleNamespace(terms=[term("wheelbase", "a")]))
    investigation = SimpleNamespace(fit=fit, members=(), posterior=SimpleNamespace(terms=[]))
    [surest] = surest_names(investigation, [part], rng.normal(size=200), [0.9], left, 1.0)
    assert surest == (EVEN if component == "a" and share > 1.0 else SUREST)
