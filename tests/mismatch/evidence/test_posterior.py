"""What a candidate is worth: against integrals and dense matrices, and what it may not depend on."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.stats import norm

from omnimate.mismatch.evidence.candidates import FURTHER_BUMP_LOG_ODDS
from omnimate.mismatch.evidence.density import FAULT_SIZE_MIXTURE, MEMBER_SIZE, log_bayes_factor, log_evidence
from omnimate.mismatch.evidence.rows import (
    apply_discrepancy,
    discrepancy_factor,
    unwhiten_nuisances,
    whiten_nuisances,
)
from tests.mismatch.conftest import RATE, SPAN, candidate, drawn, waves

SEEDS = st.integers(0, 10**6)
EFFECTS = (
    ("wheel_diameter", "a.left"),
    ("wheelbase", "b"),
    ("joint_bias", "joint_a"),
    ("link_scale", "link"),
)


def log_density_gain(data, covariance):
    """Return the log density of data by a covariance against that of white noise."""
    return -0.5 * (data @ np.linalg.solve(covariance, data) - data @ data + np.linalg.slogdet(covariance)[1])


def root_of_inverse(matrix):
    sizes, axes = np.linalg.eigh(matrix)
    return (axes / np.sqrt(sizes)) @ axes.T


@settings(max_examples=25)
@given(gram=st.floats(1e-3, 1e4), sigmas=st.floats(-8.0, 8.0))
def test_the_bayes_factor_is_the_integral_over_the_size_of_a_fault(gram, sigmas):
    score, middle = sigmas * np.sqrt(gram), sigmas / np.sqrt(gram)

    def density(size):
        prior = sum(share * norm.pdf(size, scale=scale) for scale, share in FAULT_SIZE_MIXTURE)
        return np.exp(score * size - 0.5 * gram * size**2 - 0.5 * sigmas**2) * prior

    width = min(1.0 / np.sqrt(gram), 5.0)
    edges = middle + width * np.array([-12.0, -3.0, 0.0, 3.0, 12.0])
    points = sorted({float(np.clip(edge, -60.0, 60.0)) for edge in (*edges, -60.0, -5.0, 0.0, 5.0, 60.0)})
    whole = sum(
        quad(density, first, last, epsabs=0.0, epsrel=1e-8)[0] for first, last in itertools.pairwise(points)
    )
    expected = np.log(whole) + 0.5 * sigmas**2
    assert log_bayes_factor(np.array([[gram]]), np.array([score])) == pytest.approx(expected, abs=1e-6)


@settings(max_examples=30)
@given(seed=SEEDS, width=st.integers(1, 4), size=st.floats(0.1, 10.0))
def test_the_evidence_is_the_density_of_the_data_with_against_that_without(seed, width, size):
    chance = np.random.default_rng(seed)
    columns, data = chance.normal(size=(25, width)), 2.0 * chance.normal(size=25)
    expected = log_density_gain(data, np.eye(25) + size**2 * columns @ columns.T)
    assert log_evidence(columns.T @ columns, columns.T @ data, size) == pytest.approx(expected, abs=1e-8)


@settings(max_examples=30)
@given(seed=SEEDS, width=st.integers(1, 4), size=st.floats(0.01, 30.0))
def test_shrinking_takes_the_root_of_the_noise_and_narrowing_gives_it_back(seed, width, size):
    chance = np.random.default_rng(seed)
    nuisance, rows = size * chance.normal(size=(20, width)), chance.normal(size=(20, 3))

    root = root_of_inverse(np.eye(20) + nuisance @ nuisance.T)
    white = whiten_nuisances(rows, nuisance)
    np.testing.assert_allclose(white, root @ rows, atol=1e-8)
    np.testing.assert_allclose(
        unwhiten_nuisances(white, whiten_nuisances(nuisance, nuisance)), rows, atol=1e-5
    )


@settings(max_examples=30)
@example(seed=121, width=1, size=0.05)  # a stretch in which hardly anything is loosened
@given(seed=SEEDS, width=st.integers(1, 3), size=st.floats(0.05, 10.0))
def test_loosened_rows_are_whitened_by_the_root_of_the_whole_noise(seed, width, size):
    chance = np.random.default_rng(seed)
    stretch = chance.permutation(np.repeat(np.arange(4), 6))
    part, rows = size * chance.normal(size=(24, width)), chance.normal(size=(24, 2))
    noise = np.eye(24)
    for number in range(4):
        mine = (stretch == number)[:, None]
        noise += (part * mine) @ (part * mine).T
    np.testing.assert_allclose(
        apply_discrepancy(rows, discrepancy_factor(part, stretch)), root_of_inverse(noise) @ rows, atol=1e-6
    )


def judged(seed, background=((1, 2), (0.05, 0.05)), order=None, truth=(1.5, -1.0, 0.0, 0.0)):
    """Return the posterior of four candidates, of which some are there, over a background."""
    terms = [candidate(*key) for key in EFFECTS]
    sizes = tuple(map(np.array, background)) if background else None
    return drawn(waves([400.0] * len(terms), seed), terms, np.array(truth), seed, sizes, order)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_a_judgement_does_not_depend_on_the_order_of_rows(seed):
    order = np.random.default_rng(seed).permutation(int(RATE * SPAN))
    plain, mixed = (judged(seed, ((1,), (0.1,)), own) for own in (None, order))
    for members in ((), (1,), (1, 2)):
        own, other = (posterior.given(members).judge(0) for posterior in (plain, mixed))
        for name in ("log_odds", "heldout_gain", "overdispersion", "white_log_evidence"):
            assert getattr(own, name) == pytest.approx(getattr(other, name), rel=1e-6, abs=1e-6), name
        np.testing.assert_allclose(own.coefficients, other.coefficients, rtol=1e-6)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_no_nuisance_and_no_member_ever_raises_the_information(seed):
    truth = (1.5, -1.0, 0.5, 0.0)
    plain, nuisances = (judged(seed, size, truth=truth) for size in (None, ((2, 3), (0.1, 1.0))))
    last, before = 4, float(plain.given(()).gram_and_score([4])[0][0, 0])
    assert before == pytest.approx(400.0)
    for posterior, members in ((nuisances, ()), (plain, (1,)), (nuisances, (1,)), (nuisances, (0, 1))):
        assert posterior.given(members).gram_and_score([last])[0][0, 0] <= before * (1.0 + 1e-9)
    nested = [nuisances.given(members).gram_and_score([last])[0][0, 0] for members in ((), (2,))]
    assert nested[1] <= nested[0] * (1.0 + 1e-9)


@settings(max_examples=20)
@given(seed=SEEDS, members=st.sampled_from([(), (1,)]))
def test_further_columns_are_projected_out_as_those_that_are_there(seed, members):
    posterior = judged(seed)
    conditional = posterior.given(members)
    later = posterior.regression.white[:, 3:]
    there = range(3, posterior.regression.white.shape[1])
    np.testing.assert_allclose(conditional.project_out(later), conditional.residual_columns(there), atol=1e-6)
    left = conditional.residual_columns(there)
    for gram, score in (conditional.products_of(later), conditional.gram_and_score(there)):
        np.testing.assert_allclose(score, left.T @ conditional.residual, rtol=1e-4, atol=1e-3)
        np.testing.assert_allclose(gram, left.T @ left, rtol=1e-4, atol=1e-3)


def test_coefficients_are_as_far_from_the_truth_as_their_covariance_says():
    away = []
    for seed in range(40):
        found = judged(seed, background=None).given((1,)).judge(0)
        away.append((found.coefficients[0] - 1.5) / np.sqrt(found.covariance[0, 0]))
    assert 0.6 < np.sqrt(np.mean(np.square(away))) < 1.3


def test_noise_that_is_larger_than_it_should_be_is_told_and_makes_evidence_weaker():
    terms, columns = [candidate(*EFFECTS[0])], waves([400.0], 3)
    quiet = drawn(columns, terms, np.array([0.5]), 3)
    loud = drawn(columns, terms, np.array([0.5]), 3)
    loud.regression.white[:, 0] += 1.5 * np.random.default_rng(8).normal(size=len(columns))
    own, other = (posterior.given(()).judge(0) for posterior in (quiet, loud))
    assert own.overdispersion < 1.5 < other.overdispersion
    assert other.covariance[0, 0] > 1.5 * own.covariance[0, 0]


def test_a_size_below_zero_that_makes_no_sense_is_worth_nothing():
    terms = [candidate("bump", "a.left", positive=True, times=(3.0,))]
    columns = waves([400.0], 5)
    assert drawn(columns, terms, np.array([1.0]), 5).given(()).judge(0).log_odds > 10.0
    assert drawn(columns, terms, np.array([-1.0]), 5).given(()).judge(0).log_odds == -np.inf


def test_sets_are_compared_by_the_density_of_the_data():
    terms = [candidate(*key) for key in EFFECTS[:2]]
    columns = waves([300.0, 200.0], 9)
    posterior = drawn(columns, terms, np.array([0.7, 0.2]), 9)
    data = posterior.regression.white[:, 0]
    expected = log_density_gain(data, np.eye(len(data)) + MEMBER_SIZE**2 * columns @ columns.T)
    assert posterior.evidence((0, 1)) == pytest.approx(expected + terms[0].odds + terms[1].odds, abs=1e-6)


@pytest.mark.parametrize(("fixed", "believed"), [({}, False), ({"intervals": ((10.0, 40.0),)}, True)])
def test_what_acts_all_the_time_is_not_believed_for_three_outlying_seconds(fixed, believed):
    terms, columns = [candidate("slip_patch", "a.left", **fixed)], waves([100.0], 4)
    moments = np.isin(np.floor(np.arange(len(columns)) / 4.0), (12, 45, 98))
    columns[moments] += 4.0
    posterior = drawn(columns, terms, np.array([0.0]), 4)
    posterior.regression.white[moments, 0] += columns[moments, 0]
    assert (posterior.given(()).judge(0).log_odds > 0.0) is believed


@pytest.mark.parametrize("exact", [True, False])
def test_an_event_that_is_not_of_its_shape_is_not_left_to_what_is_free_in_shape(exact):
    """A wheel takes a second to roll over an obstacle, where its law says one moment."""
    columns = np.zeros((480, 4))
    columns[[200, 201], 0] = 8.0, 10.0  # the bump
    columns[[200, 201, 202], [1, 2, 3]] = 10.0  # three free numbers of a push
    shape = np.array([8.0, 10.0, 0.0]) if exact else np.array([5.0, 12.0, 4.0])
    terms = [
        candidate("bump", "a.left", positive=True, times=(50.0,)),
        candidate("unknown", "a", odds=0.004, width=3, times=(50.0,)),
    ]
    posterior = drawn(columns, terms, np.zeros(4), 4)
    posterior.regression.white[200:203, 0] += shape
    bump, push = (posterior.given(()).judge(number) for number in (0, 1))
    assert bump.log_odds > 0.0
    assert bump.white_log_odds > push.white_log_odds


def test_a_floor_with_two_bumps_has_more_of_them_for_the_same_wheel():
    keys = [("a.left", 20.0), ("a.left", 40.0), ("a.left", 60.0), ("a.right", 60.0)]
    terms = [candidate("bump", wheel, odds=1e-5, positive=True, times=(time,)) for wheel, time in keys]
    posterior = drawn(waves([400.0] * 4, 1), terms, np.zeros(4), 1)
    assert (
        posterior.candidates.odds(2, (0, 1))
        == FURTHER_BUMP_LOG_ODDS
        > posterior.candidates.odds(2, (0,))
        == posterior.candidates.odds(2, (0, 3))
    )
    ruled_out = posterior.without([2])
    assert ruled_out.candidates.odds(2, (0, 1)) == -np.inf


@given(seed=SEEDS)
def test_an_event_as_any_robot_meets_it_is_no_fault_however_clear_it_is(seed):
    """Against its rivals it counts in full."""
    event = candidate("bump", "a.left", times=(1.0,))
    ordinary = event.kind.prior.background
    for size in (ordinary, 20.0 * ordinary):
        judgement = drawn(waves([1e6], seed), [event], np.array([size]), seed).given(()).judge(0)
        assert (judgement.log_odds > 0.0) == (size > ordinary)
        assert judgement.white_log_odds > 100.0


def test_a_truck_with_one_wrong_number_was_not_calibrated():
    keys = [("wheel_diameter", "a.left"), ("wheelbase", "a"), ("wheelbase", "b"), ("latency", "a.left")]
    terms = [candidate(*key, odds=0.03) for key in keys]
    candidates = drawn(waves([400.0] * 4, 1), terms, np.zeros(4), 1).candidates
    assert candidates.odds(1, (0,)) > candidates.odds(1, ()) == terms[1].odds
    assert candidates.odds(2, (0,)) == terms[2].odds
    assert candidates.odds(1, (3,)) == terms[1].odds


def test_an_excluded_candidate_is_impossible_given_any_set():
    posterior = judged(2)
    assert posterior.given(()).judge(0).log_odds > 0.0
    posterior = posterior.without((0,))
    assert posterior.given(()).judge(0).log_odds == posterior.given((1,)).judge(0).log_odds == -np.inf


@settings(max_examples=20)
@given(seed=SEEDS)
def test_a_recording_drawn_as_it_is_supports_a_candidate_and_a_set_as_it_does(seed):
    posterior = judged(seed, background=None, truth=(1.0, 0.0, 0.5, 0.0))
    draws = np.stack([np.ones(int(posterior.candidates.stretch.max()) + 1)] * 2)
    np.testing.assert_allclose(posterior.bootstrap_gain((0, 2), draws), 0.0, atol=1e-9)
    np.testing.assert_allclose(posterior.given((0,)).bootstrap_gain(2, draws), 0.0, atol=1e-9)


@settings(max_examples=20)
@given(seed=SEEDS)
def test_a_recording_drawn_twice_over_supports_a_candidate_as_twice_the_information_does(seed):
    posterior = drawn(waves([300.0], seed), [candidate(*EFFECTS[0])], np.array([1.0]), seed)
    conditional = posterior.given(())
    gram, score = conditional.products_without_background([0])
    draws = np.full((1, int(posterior.candidates.stretch.max()) + 1), 2.0)
    expected = log_bayes_factor(2.0 * gram, 2.0 * score) - log_bayes_factor(gram, score)
    np.testing.assert_allclose(conditional.bootstrap_gain(0, draws), expected, atol=1e-8)
