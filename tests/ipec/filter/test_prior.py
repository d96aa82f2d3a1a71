"""The prior's covariance says of scale, ratio, wheelbases and biases what the prior says."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS, SLOPE, log_prior_probabilities
from omnimate.ipec.filter.prior import (
    CALIBRATED,
    MONITORING_PRIOR,
    NOMINAL,
    SUSPECT_NAMES,
    Prior,
    suspect_directions,
)

sigmas = st.floats(1e-6, 0.1)
priors = st.builds(Prior, sigmas, sigmas, sigmas, sigmas, sigmas)


def deviation(prior, direction):
    """Return the standard deviation of a linear function of the eleven parameters."""
    return np.sqrt(direction @ prior.covariance @ direction)


@given(priors)
def test_mean_and_ratio_of_a_trucks_wheels_are_as_uncertain_as_the_prior_says(prior):
    for left, right in ((0, 1), (2, 3)):
        mean, ratio = np.zeros(11), np.zeros(11)
        mean[[left, right]], ratio[[left, right]] = 0.5, [-1.0, 1.0]
        assert deviation(prior, mean) == pytest.approx(prior.scale)
        assert deviation(prior, ratio) == pytest.approx(prior.ratio)


@given(priors)
def test_the_rest_is_independent(prior):
    covariance = prior.covariance
    rest = [prior.wheelbase] * 2 + [prior.creep] * 2 + [prior.joint] * 2 + [prior.link]
    assert covariance[4:, 4:] == pytest.approx(np.diag(np.square(rest)))
    assert not covariance[:4, 4:].any()
    assert not covariance[:2, 2:4].any()


@given(priors)
def test_it_is_a_covariance(prior):
    covariance = prior.covariance
    assert np.array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() >= -1e-15 * covariance.max()


def test_more_values_of_a_data_sheet_are_wrong_than_of_a_calibration():
    assert NOMINAL.odds > CALIBRATED.odds


def test_each_suspect_changes_what_its_name_says():
    rows = dict(zip(SUSPECT_NAMES, suspect_directions(), strict=True))
    assert rows["diameter of b.left"].tolist() == [0, 0, 1, *[0] * 8]
    assert rows["both diameters of a"].tolist() == [1, 1, *[0] * 9]
    assert rows["unequal diameters of b"][2:4] @ [-1.0, 1.0] == 1.0
    assert rows["bias of link"].tolist() == [*[0] * 10, 1]


@pytest.mark.parametrize("prior", [CALIBRATED, NOMINAL, MONITORING_PRIOR])
def test_each_reading_wanders_with_the_odds_of_the_prior(prior):
    """Forms share the odds; a truck that creeps alone on a slope needs two things to be wrong."""
    chance, wrong = np.exp(log_prior_probabilities(prior.wrong)), prior.wrong
    for number in range(len(READINGS)):
        forms = {hypothesis.form for hypothesis in HYPOTHESES if hypothesis.reading == number}
        share = 1.0 - (1.0 - wrong) / len(forms) if SLOPE in forms else 1.0
        wandering = [hypothesis.reading == number for hypothesis in HYPOTHESES]
        assert chance[wandering].sum() / chance[0] == pytest.approx(share * wrong / (1.0 - wrong))
