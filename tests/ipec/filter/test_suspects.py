"""The prior of the slow states is averaged over all sets of up to two suspects, as a direct sum shows."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.live import filter_settings
from omnimate.ipec.filter.prior import (
    CALIBRATED,
    NOMINAL,
    SUSPECT_SIZES,
    FilterNoise,
    suspect_directions,
    suspect_values,
)
from omnimate.ipec.filter.records import SLOW
from omnimate.ipec.filter.suspects import SCALES, add_suspects, discard_common_scale
from omnimate.vcan_sim.reference import reference_vehicle

WHEELS = np.array([1.0] * 4 + [0.0] * (SLOW - 4))
ROOT = np.diag([1e3] * 4 + [3e2] * 2 + [1e2] * 2 + [3e2] * 2 + [1e3])  # 1 / standard deviations of the data


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), variance=st.floats(1e-3, 1e3))
def test_the_size_of_all_wheels_is_as_uncertain_as_with_a_nuisance_along_it(seed, variance):
    """The covariance grows by the variance along the four wheels, and the mean stays."""
    chance = np.random.default_rng(seed)
    root = chance.normal(size=(SLOW, SLOW))
    told, mean = root @ root.T + np.eye(SLOW), chance.normal(size=SLOW)
    pull, covariance = told @ mean, np.linalg.inv(told)
    discard_common_scale(told, pull, variance)
    assert np.linalg.inv(told) == pytest.approx(
        covariance + variance * np.outer(WHEELS, WHEELS), rel=1e-6, abs=1e-6 * (1.0 + variance)
    )
    assert np.linalg.solve(told, pull) == pytest.approx(mean, rel=1e-5, abs=1e-5)


def averaged_directly(prior, information, pull):
    """Return mean, covariance and probabilities with a prior, by a Gaussian for each set and scale."""
    directions, known = suspect_directions(), prior.covariance
    evidences, means, spreads, members = [], [], [], []
    for count in range(3):
        for chosen in combinations(range(len(directions)), count):
            for scale in range(SCALES):
                wide = known.copy()
                for number in chosen:
                    size = SUSPECT_SIZES[number] / 3.0**scale
                    wide += size**2 * np.outer(directions[number], directions[number])
                spread = np.linalg.inv(np.linalg.inv(wide) + information)
                fit = pull @ spread @ pull - np.linalg.slogdet(np.eye(SLOW) + wide @ information)[1]
                evidences.append(0.5 * fit + count * prior.odds)
                means.append(spread @ pull)
                spreads.append(spread)
                members.append(suspect_values()[list(chosen)].any(axis=0))
    weight = np.exp(np.array(evidences) - max(evidences))
    weight /= weight.sum()
    mean = weight @ means
    away = np.array(means) - mean
    spread = np.einsum("i,ijk->jk", weight, spreads) + np.einsum("i,ij,ik->jk", weight, away, away)
    return mean, spread, weight @ members


@settings(max_examples=15)
@given(
    seed=st.integers(0, 2**32 - 1),
    wrong=st.lists(st.tuples(st.integers(0, len(SUSPECT_SIZES) - 1), st.floats(-1.0, 1.0)), max_size=2),
    prior=st.sampled_from([CALIBRATED, NOMINAL]),
)
def test_the_average_is_that_over_all_sets(seed, wrong, prior):
    """Mean, covariance and probabilities are those of the direct sum, but for negligible sets."""
    chance = np.random.default_rng(seed)
    root = ROOT @ (np.eye(SLOW) + 0.3 * chance.normal(size=(SLOW, SLOW)))
    information = root @ root.T
    truth = np.zeros(SLOW)
    for number, part in wrong:
        truth += part * SUSPECT_SIZES[number] * suspect_directions()[number]
    pull = information @ truth + root @ chance.normal(size=SLOW)
    mean, spread, wrong_values = averaged_directly(prior, information, pull)
    given_settings = filter_settings(reference_vehicle(), FilterNoise(), prior)
    found_spread = np.linalg.inv(np.linalg.inv(prior.covariance) + information)
    found_mean = found_spread @ pull
    found = add_suspects(given_settings[0], found_spread, found_mean)
    sigma = np.sqrt(np.diag(spread))
    assert found == pytest.approx(wrong_values, abs=0.02)
    assert found_mean / sigma == pytest.approx(mean / sigma, abs=0.05)
    assert found_spread / np.outer(sigma, sigma) == pytest.approx(spread / np.outer(sigma, sigma), abs=0.05)
