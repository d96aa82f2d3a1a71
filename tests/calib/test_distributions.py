"""The distributions against scipy.stats, which defines them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from omnimate.calib import distributions as ours

probabilities = st.floats(1e-6, 1.0 - 1e-6)
freedoms = st.integers(1, 60)
ratios = st.floats(0.0, 30.0)


@given(probabilities, freedoms)
def test_quantiles_are_those_of_scipy(probability, freedom):
    assert ours.student_quantile(probability, freedom) == stats.t.ppf(probability, freedom)
    assert ours.chi2_quantile(probability, freedom) == stats.chi2.ppf(probability, freedom)
    assert ours.chi2_upper_limit(probability, [freedom])[0] == stats.chi2.isf(probability, freedom)
    assert ours.normal_upper_limit(probability) == stats.norm.isf(probability)


@given(ratios, freedoms, freedoms)
def test_tails_are_those_of_scipy(ratio, above, below):
    assert ours.fisher_tail(ratio, above, below) == stats.f.sf(ratio, above, below)
    assert ours.student_tail(ratio, below) == stats.t.sf(ratio, below)
    assert ours.normal_probability(ratio - 15.0) == stats.norm.cdf(ratio - 15.0)


def test_a_quantile_and_its_tail_belong_together():
    assert ours.student_tail(ours.student_quantile(0.975, 8), 8) == pytest.approx(0.025)
