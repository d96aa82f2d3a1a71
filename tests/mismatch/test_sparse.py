"""Plain choices of terms: what is planted in white noise is found, and nothing else."""

import numpy as np
import pytest

from omnimate.mismatch import sparse
from omnimate.mismatch.choose import EMPTY, Choice
from omnimate.mismatch.sparse import METHODS, NOTHING, chosen, descend, sensible, weights
from omnimate.mismatch.terms import Term

ROWS = 400


def rows_of(planted, *, seed=3, count=12):
    """Return columns, and data in which some are planted, as {number: coefficient}."""
    chance = np.random.default_rng(seed)
    columns = chance.normal(size=(ROWS, count))
    return columns, chance.normal(size=ROWS) + sum(size * columns[:, one] for one, size in planted.items())


def choice_of(planted, *, positive=False, count=12):
    """Return terms of one column each, and data in which some are planted."""
    columns, data = rows_of(planted, count=count)
    white = np.column_stack([data, columns])
    terms = [Term("wheelbase", str(one), (), {}, 0.0, positive) for one in range(count)]
    return Choice(terms, [slice(one, one + 1) for one in range(1, count + 1)], white.T @ white)


@pytest.mark.parametrize("name", METHODS)
def test_what_is_planted_is_chosen(name):
    assert chosen(choice_of({4: 0.6}), METHODS[name], ROWS) == {4}


@pytest.mark.parametrize("name", ["STLSQ", "lasso"])
def test_three_planted_at_once_are_all_chosen(name):
    assert chosen(choice_of({1: 0.6, 4: -0.5, 9: 1.0}), METHODS[name], ROWS) == {1, 4, 9}


@pytest.mark.parametrize("threshold", [0.05, 0.1, 0.2, 0.4])
def test_thresholded_least_squares_keeps_the_terms_that_pysindy_keeps(threshold, monkeypatch):
    optimizers = pytest.importorskip(
        "pysindy.optimizers", reason="pysindy is not installed: the extra `peers`"
    )
    planted = {1: 0.6, 4: -0.5, 7: 0.25, 9: 1.0, 11: 0.08}
    columns, data = rows_of(planted)
    peer = optimizers.STLSQ(threshold=threshold, alpha=1.0, unbias=False).fit(columns, data[:, None])
    monkeypatch.setattr(sparse, "THRESHOLDS", np.array([threshold]))
    (own,) = sparse.stlsq(choice_of(planted))
    assert own == set(np.flatnonzero(peer.coef_[0]))
    assert own


@pytest.mark.parametrize("name", METHODS)
def test_noise_alone_is_nothing(name):
    assert chosen(choice_of({}), METHODS[name], ROWS) == EMPTY


def test_coordinate_descent_ends_where_the_lassos_conditions_hold():
    total = choice_of({1: 0.6, 4: -0.5}).total
    total = total / np.sqrt(np.outer(np.diag(total), np.diag(total)))
    gram, own, values = total[1:, 1:], total[1:, 0], np.zeros(12)
    descend(gram, own, 0.1, values)
    slope = own - gram @ values
    np.testing.assert_allclose(slope[values != 0.0], 0.1 * np.sign(values[values != 0.0]), atol=1e-4)
    assert np.abs(slope).max() < 0.1 + 1e-4


def test_a_coefficient_that_makes_no_sense_is_dropped():
    choice = choice_of({1: 0.6, 4: -0.5}, positive=True)
    assert sensible(choice, frozenset({1, 4})) == {1}


def test_the_weights_of_a_member_and_what_may_stand_for_it_add_up_to_one():
    choice = choice_of({4: 0.25})
    shares = weights(choice, frozenset({4}), 4, ROWS)
    assert sum(shares.values()) == pytest.approx(1.0)
    assert shares["wheelbase", "4"] > 0.9 > shares[NOTHING]
