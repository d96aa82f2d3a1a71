"""Sets of effects compared by their evidence."""

import numpy as np
import pytest

from omnimate.mismatch.choose import EMPTY, RARE, TAIL, Choice, inclusion, rivals, thinned, tolerant
from omnimate.mismatch.terms import Term


def term(name, component="a", *, positive=False):
    return Term(name, component, (None,), {}, 0.0, positive)


@pytest.fixture
def data():
    """Return 400 rows: the data, which are the first column three times, and four columns."""
    chance = np.random.default_rng(1)
    columns = chance.normal(size=(400, 4))
    columns[:, 1] = columns[:, 0] + 0.02 * chance.normal(size=400)
    rows = 3.0 * columns[:, 0] + chance.normal(size=400)
    return np.column_stack([rows, columns])


def choice(data, **kinds):
    terms = [term("one"), term("twin"), term("third"), term("fourth", positive=kinds.get("positive", False))]
    return Choice(terms, [slice(number, number + 1) for number in range(1, 5)], data.T @ data)


def test_the_worth_of_a_set_is_its_bayes_factor(data):
    data[:, 0] /= 3.0
    own = choice(data)
    factor = bayes_factor(data, 1.0)
    assert own.worth(frozenset({0, 2})) == pytest.approx(factor + own.prior(0) + own.prior(2))


def test_a_large_effect_is_rarer_but_no_wonder(data):
    own = choice(data)
    factor = bayes_factor(data, TAIL) - RARE
    assert own.worth(frozenset({0, 2})) == pytest.approx(factor + own.prior(0) + own.prior(2))
    assert factor > bayes_factor(data, 1.0) - RARE


def bayes_factor(data, first):
    """Return the log evidence of the first column, of a prior size, and the third, against nothing."""
    columns, rows = data[:, [1, 3]] * [first, 1.0], data[:, 0]
    with_it = np.eye(400) + columns @ columns.T
    return (
        -0.5 * np.linalg.slogdet(with_it)[1] - 0.5 * rows @ np.linalg.solve(with_it, rows) + 0.5 * rows @ rows
    )


def test_what_is_there_is_chosen_and_what_looks_like_it_is_its_rival(data):
    own = choice(data)
    best = own.best(EMPTY)
    assert len(best) == 1
    assert best <= {0, 1}
    others = [key for key, _ in rivals(own, best, next(iter(best)))]
    assert others[0] in {("one", "a"), ("twin", "a")}
    assert sum(inclusion(own)[name, "a"] for name in ("one", "twin")) > 0.99


def test_noise_alone_is_nothing():
    rows = np.random.default_rng(2).normal(size=(400, 5))
    assert choice(rows).best(EMPTY) == EMPTY


def test_a_loss_below_zero_makes_no_sense(data):
    data[:, 4] = -data[:, 1]
    assert choice(data, positive=True).worth(frozenset({3})) == -np.inf
    assert choice(data).worth(frozenset({3})) > 0.0


def test_a_set_is_thinned_to_what_it_needs(data):
    assert thinned(choice(data), frozenset({0, 2, 3})) == frozenset({0})


def test_what_every_robot_has_a_little_of_is_integrated_out(data):
    sizes = np.array([0.0, 0.1, 0.0, 0.0, 0.0])
    spread = np.eye(400) + 0.01 * np.outer(data[:, 1], data[:, 1])
    np.testing.assert_allclose(
        tolerant(data.T @ data, sizes), data.T @ np.linalg.solve(spread, data), atol=1e-6
    )


def test_a_push_stands_in_the_place_of_an_event_and_not_beside_it(data):
    own = choice(data)
    own.terms[0] = term("bump", "a.left")
    own.terms[2] = Term("unknown", "a", (None,), {"quantity": "single moments", "instead": True}, 0.0, False)
    assert own.worth(frozenset({0, 2})) == -np.inf
    assert own.worth(frozenset({0})) > 0.0
    own.terms[0] = term("bump", "b.left")
    own.known.clear()
    assert own.worth(frozenset({0, 2})) > 0.0


def test_what_is_of_both_trucks_is_tried_on_both_at_once(data):
    """Either alone is worth nothing: only their sum is in the data."""
    chance = np.random.default_rng(5)
    shared = chance.normal(size=400)
    data[:, 1:3] = np.stack([shared, -shared], axis=1) * 40.0 + chance.normal(size=(400, 2))
    data[:, 0] = 3.0 * (data[:, 1] + data[:, 2]) + chance.normal(size=400)
    own = choice(data)
    own.terms[:2] = [term("slope", "a"), term("slope", "b")]
    assert own.best(frozenset({3})) >= {0, 1}


def test_what_loosens_a_shape_is_no_part_of_an_effects_size(data):
    """It may be negative, and large only at the price of a prior without tails."""
    data[:, 0] += 6.0 * data[:, 3] - 6.0 * data[:, 4]
    own = choice(data)
    own.places[3] = slice(3, 5)
    own.terms[3] = term("bump", "a.left", positive=True)
    columns, rows = data[:, 3:5] * [TAIL, 1.0], data[:, 0]
    with_it = np.eye(400) + columns @ columns.T
    factor = (
        -0.5 * np.linalg.slogdet(with_it)[1] - 0.5 * rows @ np.linalg.solve(with_it, rows) + 0.5 * rows @ rows
    )
    assert own.worth(frozenset({3})) == pytest.approx(factor - RARE + own.prior(3))


def test_a_search_leaves_a_set_whose_sizes_make_no_sense(data):
    columns = np.random.default_rng(2).normal(size=(400, 2))
    rows = np.column_stack([-3.0 * columns.sum(axis=1) + 2.0 * data[:, 1], columns, data[:, 1]])
    terms = [term("first", positive=True), term("second", positive=True), term("third")]
    own = Choice(terms, [slice(number, number + 1) for number in range(1, 4)], rows.T @ rows)
    assert own.worth(frozenset({0, 1, 2})) == -np.inf
    assert own.best(frozenset({0, 1, 2})) == frozenset({2})
