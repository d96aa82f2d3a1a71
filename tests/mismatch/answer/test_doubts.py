"""A weak event that comes with a strong one of another wheel may be what that one's law leaves."""

import pytest

from omnimate.mismatch.answer.doubts import _are_discrepancies
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
