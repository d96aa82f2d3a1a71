"""Events with a free shape: what rocks a truck on its way over an obstacle is not taken for a push."""

import numpy as np
import pytest

from omnimate.mismatch.choose import Choice
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.shape import height, loosened, retold
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.terms import term
from omnimate.mismatch.windows import windows_of

TRUE = (20.0, 55.0)
PATCH = ((30.0, 36.0),)


@pytest.fixture(scope="module")
def own(drive, effect):
    """Return a regression with a term of two bumps and one of a patch, and the choice between them."""
    recording = drive(effect("bump", "b.right", times=TRUE, lost=(3e-3, 3e-3)))
    windows = [windows_of(signals_of(recording))]
    regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
    terms = [term("bump", "b.right", times=TRUE), term("slip_patch", "a.left", intervals=PATCH)]
    return regression, Choice(terms, regression.add(terms), regression.total)


def test_a_loosened_event_has_its_own_columns_first_and_then_its_shape(own):
    regression, choice = own
    (bump, columns), (patch, stretches) = loosened(regression, choice, frozenset({0, 1}))
    assert (bump.effect, patch.effect) == ("bump", "slip_patch")
    assert len(columns[0]) == 2 + 2 * 9
    assert len(stretches[0]) == 1 + round(6.0 / 0.25)
    place, push = choice.places[0], regression.raw[0][0]
    assert np.array_equal(columns[0][0][0], push[:, :, place.start])


def test_a_shape_acts_at_its_event_only(own):
    regression, choice = own
    (_, columns), (_, stretches) = loosened(regression, choice, frozenset({0, 1}))
    middle = regression.windows[0].time[1:]
    for inputs, _ in columns[0][2:11]:
        acted = middle[np.abs(inputs).sum(axis=1) > 0.0]
        assert np.all(np.abs(acted - TRUE[0]) < 1.0)
    for inputs, _ in stretches[0][1:]:
        acted = middle[np.abs(inputs).sum(axis=1) > 0.0]
        assert np.all((acted > PATCH[0][0]) & (acted < PATCH[0][1] + 0.25))


def test_a_free_shape_costs_more_than_it_explains_where_the_law_is_exact(own):
    regression, choice = own
    ((bump, columns),) = loosened(regression, choice, frozenset({0}))
    place = regression.extend(columns)
    both = Choice([*choice.terms, bump], [*choice.places, place], regression.total)
    assert both.worth(frozenset({0})) > both.worth(frozenset({2}))
    regression.drop(place.start)


def test_a_patch_reaches_over_the_bumps_beside_it_and_leaves_those_elsewhere(own):
    regression, _ = own
    near, far = (29.6, 36.4), (20.0, 55.0)
    bumps = term("bump", "a.left", times=(far[0], *near, far[1]))
    terms = [term("slip_patch", "a.left", intervals=PATCH), bumps, term("bump", "b.right", times=near)]
    ((wheel, (patch, rest)),) = retold(regression, terms, frozenset({0, 1, 2}))
    assert (wheel, patch.key, rest.key) == ("a.left", terms[0].key, bumps.key)
    ((start, end),) = patch.fixed["intervals"]
    assert start == near[0]
    assert near[1] < end < far[1]
    assert rest.fixed["times"] == far
    assert not list(retold(regression, terms, frozenset({0, 2})))


def test_a_patch_with_one_edge_only_may_be_a_step_of_the_radius_there(own):
    regression, _ = own
    time = regression.windows[0].time
    first, last, middle = float(time[0]), float(time[-1]), 40.0
    bump = term("bump", "a.left", times=(20.0,))
    for span, steps in (((first - 3.0, middle), 1), ((middle, last), 1), ((30.0, middle), 0)):
        terms = [term("slip_patch", "a.left", intervals=(span,)), bump]
        told = [
            new for _, new in retold(regression, terms, frozenset({0, 1})) if new[0].effect == "radius_step"
        ]
        assert len(told) == steps
        assert all(new[0].fixed["time"] == middle and new[1] is bump for new in told)


@pytest.mark.parametrize("edge", [1e-3, 5e-3, 1e-2])
def test_the_height_of_an_edge_is_told_by_the_way_that_it_costs(edge):
    q = np.arccos(1.0 - edge / 0.075)
    assert height(0.075, 2.0 * 0.075 * (q - np.sin(q))) == pytest.approx(edge)
