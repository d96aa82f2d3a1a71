"""Scatter, pooled over both directions."""

import numpy as np
import pytest

from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.calib.umbmark.scatter import MIRROR, scatter_of, weights_of
from studies.papers.trials import Trial, floor_covariance


def test_mirrored_runs_pool_their_correlations() -> None:
    """Many runs in both directions show the covariance that they were drawn from, with its signs."""
    wanted = floor_covariance(0.025)
    errors = Trial(0.99, 1.001, wanted, runs=4000).drive(np.random.default_rng(3)).errors
    scatter = scatter_of(errors)
    unit = np.sqrt(np.diag(wanted))
    assert scatter.freedom == 7998
    assert scatter.covariance / np.outer(unit, unit) == pytest.approx(wanted / np.outer(unit, unit), abs=0.06)
    of_centres = scatter.of_centres((4000, 4000))
    assert of_centres[:3, :3] * 4000 == pytest.approx(np.outer(MIRROR, MIRROR) * scatter.covariance)
    assert not of_centres[:3, 3:].any()


def test_positions_scatter_as_section_v_says() -> None:
    """sigma of x and y is `ReturnErrors.scatter`; one run each way has none."""
    errors = Trial(0.99, 1.001, floor_covariance(0.025)).drive(np.random.default_rng(4)).errors
    assert scatter_of(errors).sigma[:2] == pytest.approx([errors.scatter] * 2)
    alone = ReturnErrors(errors.cw[:1].copy(), errors.ccw[:1].copy(), 4.0)
    assert np.isnan(scatter_of(alone).covariance).all()


def test_weights_grow_with_the_runs_and_stay_finite() -> None:
    """Four times as many runs weigh twice as much; runs without scatter do not weigh infinitely."""
    weights = weights_of(np.array([0.02, 0.02, 0.0]), (4, 1), 4.0)
    assert weights[0, 0] == pytest.approx(100.0)
    assert weights[0] == pytest.approx(2.0 * weights[1])
    assert np.isfinite(weights).all()
