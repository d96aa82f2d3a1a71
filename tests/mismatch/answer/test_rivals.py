"""Probabilities of rivals: what variants, single stretches and single moments may do to them."""

from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.mismatch.answer.rivals import rivalry
from tests.mismatch.conftest import candidate, drawn

ROWS, STRETCH = 480, 16  # of a drawn regression, and rows in a stretch of it
DIAMETER, LOSS = ("wheel_diameter", "a.left"), ("count_loss", "a.left")


def shares(posterior, members, member):
    """Return the probabilities of a member and of its rivals, by name."""
    answer = rivalry(SimpleNamespace(posterior=posterior, members=members), member)
    return {posterior.terms[member].key: answer.probability, **dict(answer.rivals)}


def pair(apart):
    """Return two columns that differ by some rows only."""
    both = np.cos(np.arange(ROWS))
    return np.stack([both + apart, both], axis=1) * np.sqrt(300.0 / ROWS)


@pytest.mark.parametrize("variants", [2, 5])
def test_a_name_is_as_probable_whether_its_odds_are_one_variant_s_or_shared_by_several(variants):
    columns = pair(0.3 * np.sin(0.7 * np.arange(ROWS)))
    terms = [candidate(*DIAMETER), candidate(*LOSS, odds=0.01, above=0.1)]
    single = shares(drawn(columns, terms, np.array([1.0, 0.0]), seed=1), (0,), 0)
    terms = [terms[0], *(candidate(*LOSS, odds=0.01 / variants, above=0.1 * at) for at in range(variants))]
    columns = np.column_stack([columns[:, 0], *[columns[:, 1]] * variants])
    shared = shares(drawn(columns, terms, np.eye(variants + 1)[0], seed=1), (0,), 0)
    assert 0.01 < single[LOSS] < 0.99
    assert shared[LOSS] == pytest.approx(single[LOSS], rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_what_a_single_stretch_says_is_not_sure_and_what_all_of_them_say_is(seed):
    terms = [candidate(*DIAMETER), candidate(*LOSS, above=0.1)]
    wave = np.sin(0.7 * np.arange(ROWS))
    once = np.where(np.arange(ROWS) // STRETCH == 7, np.sqrt(ROWS / STRETCH) * wave, 0.0)
    sure = shares(drawn(pair(0.8 * wave), terms, np.array([1.0, 0.0]), seed), (0,), 0)
    unsure = shares(drawn(pair(0.8 * once), terms, np.array([1.0, 0.0]), seed), (0,), 0)
    assert sure[DIAMETER] > 0.99
    assert 0.5 < unsure[DIAMETER] < 0.9


def test_what_happened_once_is_sure_though_it_cannot_be_drawn_again():
    columns = np.zeros((ROWS, 1))
    columns[200:204, 0] = 10.0
    bump = candidate("bump", "a.left", times=(50.0,))
    assert shares(drawn(columns, [bump], np.array([1.0]), seed=1), (0,), 0)["bump", "a.left"] > 0.99


def test_the_same_recording_has_the_same_probabilities_again():
    columns = pair(0.3 * np.sin(0.7 * np.arange(ROWS)))
    terms = [candidate(*DIAMETER), candidate(*LOSS, above=0.1)]
    first, again = (shares(drawn(columns, terms, np.array([1.0, 0.0]), seed=3), (0,), 0) for _ in range(2))
    assert first == again
