"""The search for sets: nothing in noise, one, two, and two that hide each other."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.evidence.conditional_fit import IMPOSSIBLE, Judgement
from omnimate.mismatch.evidence.search import (
    NAMELESS_MARGIN,
    _best_of,
    _prune,
    _without_what_cancels,
    may_replace,
    replacements_of_two,
    search,
)
from tests.mismatch.conftest import candidate, drawn, waves

NUMBERS = [("wheel_diameter", wheel) for wheel in ("a.left", "a.right", "b.left", "b.right")] + [
    ("wheelbase", "a"),
    ("wheelbase", "b"),
    ("joint_bias", "joint_a"),
    ("joint_bias", "joint_b"),
]
FAULTS = [
    ("link_bias", "link"),
    ("link_scale", "link"),
    ("wheel_misalignment", "a"),
    ("wheel_misalignment", "b"),
    *(("latency", channel) for channel in ("a.left", "a.right", "joint_a", "joint_b", "link")),
    *(("radius_vs_speed", wheel) for wheel in ("a.left", "a.right", "b.left", "b.right")),
    *(("traction_slip", wheel) for wheel in ("a.left", "a.right", "b.left", "b.right")),
]


LIBRARY = [candidate(*key, odds=0.1) for key in NUMBERS] + [candidate(*key, odds=0.01) for key in FAULTS]


def made(seed, truth=None, library=LIBRARY):
    """Return the posterior of a library with its background sizes, of which some are there."""
    chance = np.random.default_rng(seed)
    columns = waves(10.0 ** chance.uniform(1.5, 4.0, len(library)), seed)
    sizes = np.zeros(len(library))
    for number, size in (truth or {}).items():
        sizes[number] = size
        columns[:, number] *= np.sqrt(1000.0) / np.linalg.norm(columns[:, number])
    background = np.arange(1, len(library) + 1), np.full(len(library), 0.02)
    return drawn(columns, library, sizes, seed, background)


def judged(white, log_odds, prior=0.0):
    evidence = {"white_log_odds": white + prior, "white_log_evidence": white}
    return Judgement(np.ones(1), np.eye(1), log_odds=log_odds, **evidence)


def test_in_two_hundred_regressions_of_noise_at_most_two_have_anything_found():
    found = [search(made(seed)) for seed in range(200)]
    assert sum(bool(members) for members in found) <= 2, [members for members in found if members]


@pytest.mark.parametrize("seed", range(5))
def test_one_and_three_effects_are_found_and_nothing_beside_them(seed):
    assert search(made(seed, {9: 1.0})) == (9,)
    assert search(made(seed, {0: 0.5, 9: 1.0, 14: -1.0})) == (0, 9, 14)


@pytest.mark.parametrize("seed", range(5))
def test_two_effects_that_hide_each_other_are_found_together(seed):
    axes = np.linalg.qr(waves(np.ones(len(LIBRARY)), seed))[0]
    columns = np.sqrt(150.0) * axes
    columns[:, 1] = 0.92 * columns[:, 0] + np.sqrt(1.0 - 0.92**2) * columns[:, 1]
    truth = np.zeros(len(LIBRARY))
    truth[[0, 1]] = 2.0, -2.0
    posterior = drawn(columns, LIBRARY, truth, seed)
    both = [posterior.given((1 - number,)).judge(number).log_odds for number in (0, 1)]
    alone = [posterior.given(()).judge(number).log_odds for number in (0, 1)]
    assert min(both) > 10.0 + max(alone)
    assert search(posterior) == (0, 1)


@pytest.mark.parametrize("seed", range(3))
def test_the_search_comes_to_the_same_set_wherever_it_starts(seed):
    posterior = made(seed, {0: 0.5, 9: 1.0})
    assert search(posterior, ()) == search(posterior, (0, 9)) == search(posterior, (3, 17)) == (0, 9)


def test_of_two_names_for_the_same_column_the_likelier_is_taken():
    terms = [candidate("joint_bias", "joint_a", odds=0.01), candidate("wheel_misalignment", "a", odds=0.1)]
    column = waves([500.0], 2)
    assert search(drawn(np.hstack([column, column]), terms, np.array([1.0, 0.0]), 2)) == (1,)


def test_two_members_alike_are_exchanged_for_the_single_effect_that_is_both():
    terms = [candidate("latency", "b.left"), candidate("latency", "b.right"), candidate("traction_slip", "b")]
    columns = waves([500.0, 500.0, 500.0], 6)
    columns[:, 2] = columns[:, 0] + columns[:, 1]
    posterior = drawn(columns, terms, np.array([0.0, 0.0, 1.0]), 6)
    assert search(posterior, (0, 1)) == (2,)


def test_what_has_no_name_takes_the_place_of_two_names_of_its_component_that_share_it():
    terms = [
        candidate("wheel_diameter", "b.left"),
        candidate("radius_vs_speed", "b.left"),
        candidate("unknown", "b.left", quantity="time", acts_on="travel"),
    ]
    terms[2] = replace(terms[2], probes=())
    columns = waves([500.0, 500.0, 800.0], 7)
    columns[:, 2] = columns[:, 0] + columns[:, 1]
    posterior = drawn(columns, terms, np.array([0.0, 0.0, 1.0]), 7)
    posterior.places[2] = slice(3, 4)
    assert search(posterior, (0, 1)) == (2,)
    elsewhere = replace(terms[0], component="a.left")
    posterior.terms[0] = elsewhere
    assert 2 not in [single for single, _ in replacements_of_two(posterior, (0, 1), 0, 1)]


def test_of_rivals_that_may_be_there_the_likelier_wins_though_it_leaves_noise_that_is_less_white():
    """A spread is the noise's, which rivals share: it says whether anything is there, and not which."""
    likelier, whiter, absent = judged(350.0, 177.0), judged(340.0, 300.0), judged(400.0, -1.0)
    assert _best_of([(0, likelier), (1, whiter), (2, absent)]) == (0, likelier)


@pytest.mark.parametrize("seed", range(3))
def test_of_two_that_nobody_believes_in_together_the_likelier_stays(seed):
    terms = [candidate("gear_harmonic", "b.left", odds=0.01), candidate("wheelbase", "b", odds=0.1)]
    axes = np.linalg.qr(waves(np.ones(2), seed))[0]
    columns = np.stack([60.0 * axes[:, 0], 0.15 * axes[:, 0] + 3.0 * axes[:, 1]], axis=1)
    posterior = drawn(columns, terms, np.array([3.9, -4.0]), seed)
    assert posterior.given((1,)).judge(0).log_odds == IMPOSSIBLE
    assert posterior.given((0,)).judge(1).log_odds > 0.0
    assert _prune(posterior, (0, 1)) == (0,)


def test_where_all_channels_or_all_but_one_are_late_none_is():
    terms = [replace(term, positive=term.effect == "latency") for term in LIBRARY]
    late = [number for number, term in enumerate(terms) if term.positive]
    posterior = made(1, {**dict.fromkeys(late, 1.0), 9: 1.0}, terms)
    assert _without_what_cancels(posterior, (9, *late)) == (9,)
    assert _without_what_cancels(posterior, (9, *late[1:])) == (9,)
    assert _without_what_cancels(posterior, (9, *late[2:])) == (9, *late[2:])


@pytest.mark.parametrize("other", range(3))
def test_where_all_clocks_but_one_run_off_that_one_runs_off_the_opposite_amount(other):
    terms = [candidate("clock_drift", part, odds=0.01) for part in ("a.left", "a.right", "poses")]
    posterior = made(1, dict.fromkeys(range(3), 1.0), terms)
    assert _without_what_cancels(posterior, tuple({0, 1, 2} - {other})) == (other,)
    assert _without_what_cancels(posterior, (0, 1, 2)) == ()


def test_effects_of_a_kind_that_are_likelier_all_gone_go_together():
    terms = [candidate("joint_bias", joint, odds=0.01) for joint in ("joint_a", "joint_b")]
    column = 30.0 * np.linalg.qr(waves([1.0], 3))[0]
    posterior = drawn(np.hstack([column, column]), terms, np.zeros(2), 3)
    assert posterior.evidence((0, 1)) < 0.0
    assert _without_what_cancels(posterior, (0, 1)) == ()


@pytest.mark.parametrize(
    ("white", "log_odds", "prior", "expected"),
    [
        (5.0, 5.0, 0.0, False),
        (1.0, 1.0, 0.0, False),
        (1.0, -9.0, 0.0, True),
        (1.0, -9.0, 4.5, False),
        (-9.0, 1.0, 0.0, True),
    ],
    ids=["as good", "a little better", "predicts better", "is less likely", "explains better"],
)
def test_an_error_without_a_name_must_be_better_than_a_name_by_a_margin(white, log_odds, prior, expected):
    """White noise may say one thing, and unseen stretches another."""
    name = candidate("slip_patch", "b.left")
    nameless = candidate("unknown", "b.left", quantity="time", acts_on="travel")
    posterior = drawn(waves([100.0, 100.0], 1), [name, nameless], np.zeros(2), 1)
    unknown = judged(NAMELESS_MARGIN, NAMELESS_MARGIN)
    known = judged(white, log_odds, prior)
    assert may_replace(posterior, 1, unknown, 0, known) is expected
    assert may_replace(posterior, 0, known, 1, unknown)
