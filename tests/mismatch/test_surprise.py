"""What stands against events: pushes at their moments, wherever these are."""

import numpy as np
import pytest

from omnimate.mismatch.choose import EMPTY, Choice
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.investigate import tolerated
from omnimate.mismatch.leftover import leftover
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.surprise import surprises
from omnimate.mismatch.terms import term
from omnimate.mismatch.windows import windows_of


@pytest.fixture(scope="module")
def regression(drive):
    """Return a healthy drive, whitened."""
    windows = [windows_of(signals_of(drive()))]
    return Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))


@pytest.mark.parametrize("before", [0.0, 0.1, 0.3])
def test_an_event_at_the_very_end_of_a_recording_has_a_push_against_it(regression, before):
    end = float(regression.windows[0].time[-1])
    bump = term("bump", "b.left", times=(end - before,))
    left = leftover(regression, Choice([], [], regression.total), EMPTY)
    pushes = [one for one, _ in surprises(regression, left, [bump]) if "instead" in one.fixed]
    assert [one.component for one in pushes] == ["a", "b"]


def test_an_obstacle_that_many_terms_hold_is_tolerated_once(regression):
    bare = regression.bare()
    terms = [term("bump", "b.left", times=(20.0, *more)) for more in ((), (30.0,), (40.0,))]
    places = bare.add(terms)
    many = tolerated(bare, terms, places, slice(1, 1))
    once = tolerated(bare, terms[:1], places[:1], slice(1, 1))
    others = [places[1].start + 1, places[2].start + 1]  # of the obstacles that one term alone has
    own = places[0].start
    without = np.delete(np.delete(many, others, axis=0), others, axis=1)
    assert without[own, own] == pytest.approx(once[own, own], rel=0.05)
