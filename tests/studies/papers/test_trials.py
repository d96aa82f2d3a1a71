"""The numbers of the issue, counted; and the bound below them."""

from dataclasses import replace

import numpy as np
import pytest

from studies.papers.trials import (
    Trial,
    efficiency,
    factor_bound,
    floor_covariance,
    free_coverage,
    plain_covariance,
)

FIGURE_11 = (0.98874, 1.00084)


def test_the_weighted_fit_reaches_the_bound() -> None:
    """Weighed by the true scatter it has the variance of the bound; by its own, 10 % more with 5 + 5 runs."""
    trial = Trial(*FIGURE_11, plain_covariance(0.022))
    assert efficiency(trial, 20_000, estimated_weights=False) == pytest.approx([1.0, 1.0], abs=0.05)
    assert efficiency(trial, 20_000) == pytest.approx([1.09, 1.09], abs=0.05)
    assert efficiency(replace(trial, runs=20), 10_000) == pytest.approx([1.02, 1.02], abs=0.05)


def test_the_bound_shrinks_with_runs_and_with_headings() -> None:
    """Twice the runs halve it; headings that are not measured make it larger."""
    covariance = plain_covariance(0.022)
    five, ten = (factor_bound(FIGURE_11, (n, n), covariance) for n in (5, 10))
    assert ten == pytest.approx(0.5 * five, rel=1e-12)
    blind = factor_bound(FIGURE_11, (5, 5), covariance + np.diag([0.0, 0.0, np.inf]))
    assert (np.diag(blind) > 1.2 * np.diag(five)).all()


def test_the_bound_is_the_textbook_s_for_headings_alone() -> None:
    """alpha = (th_cw - th_ccw) / 8 has a variance of sigma^2 / (32 n), and E_b that times (2 / pi)^2."""
    covariance = np.diag([1e6, 1e6, 0.01**2])
    bound = factor_bound((1.0, 1.0), (5, 5), covariance)
    assert bound[0, 0] == pytest.approx(0.01**2 / 160.0 * (2.0 / np.pi) ** 2, rel=1e-6)


@pytest.mark.slow
def test_a_wheelbase_fitted_with_everything_free_is_inside_its_interval() -> None:
    """25 experiments of 0.95 each: 20 are three and a half sigma below; every one of them has a solution."""
    share, fits = free_coverage(Trial(*FIGURE_11, floor_covariance(0.025), runs=2), 25, seed=400)
    assert fits == 25
    assert share >= 0.8
