"""The filter that whitens, against the covariance of everything at once."""

import numpy as np
import pytest

from omnimate.mismatch.noise.whitening import adjoint, gains_of, whiten

STEPS, STATES, ROWS = 6, 3, 2


@pytest.fixture
def model():
    """Return a small random model: transition, links, process, observe, variance, start.

    Among its factors are those with which the filter may skip a product or a sum, and their neighbours.
    """
    chance = np.random.default_rng(3)
    transition = np.tile(np.eye(STATES), (STEPS, 1, 1))
    transition[:, 0, 1] = chance.normal(size=STEPS)
    transition[:, 1, 2] = chance.normal(size=STEPS)
    transition[:, 2, 2] = 0.7, 0.0, 2.0, 0.7, 0.7, 0.7
    transition[:4, 0, 1] = transition[1:5, 1, 2] = 1.0, 0.0, -1.0, 1.0
    links = np.array([[0, 1], [1, 2]])
    root = chance.normal(size=(STEPS, STATES, STATES))
    process = 0.1 * root @ root.transpose(0, 2, 1)
    observe = chance.normal(size=(STEPS + 1, ROWS, STATES))
    observe[3] = [[1.0, 0.0, -1.0], [0.0, -1.0, 1.0]]
    variance = chance.uniform(0.5, 1.0, (STEPS + 1, ROWS))
    variance[2, 1] = variance[4, 0] = np.nan
    return transition, links, process, observe, variance, np.diag([1.0, 2.0, 0.5])


def dense(model):
    """Return the covariance (K, K) of all measurements, and where a push in each step is seen (M, n, K)."""
    transition, _, process, observe, variance, start = model
    whole = np.zeros(((STEPS + 1) * STATES,) * 2)
    carry = np.zeros((STEPS + 1, STEPS + 1, STATES, STATES))
    for first in range(STEPS + 1):
        carry[first, first] = np.eye(STATES)
        for last in range(first + 1, STEPS + 1):
            carry[first, last] = transition[last - 1] @ carry[first, last - 1]
    sources = [start, *process]
    for one in range(STEPS + 1):
        for other in range(STEPS + 1):
            block = sum(
                carry[first, one] @ sources[first] @ carry[first, other].T
                for first in range(min(one, other) + 1)
            )
            whole[one * STATES : (one + 1) * STATES, other * STATES : (other + 1) * STATES] = block
    see = np.zeros(((STEPS + 1) * ROWS, (STEPS + 1) * STATES))
    for moment in range(STEPS + 1):
        see[moment * ROWS : (moment + 1) * ROWS, moment * STATES : (moment + 1) * STATES] = observe[moment]
    known = np.isfinite(variance.ravel())
    covariance = (see @ whole @ see.T)[np.ix_(known, known)] + np.diag(variance.ravel()[known])
    pushes = np.zeros((STEPS, STATES, known.sum()))
    for step in range(STEPS):
        for state in range(STATES):
            moved = np.concatenate(
                [
                    carry[step + 1, moment][:, state] if moment > step else np.zeros(STATES)
                    for moment in range(STEPS + 1)
                ]
            )
            pushes[step, state] = (see @ moved)[known]
    return covariance, pushes, known


def filtered(model, measured, inputs=None):
    """Return whitened innovations of measurements and inputs, and the filter's gains and variances."""
    transition, links, process, observe, variance, start = model
    gains, spread = gains_of(transition, links, process, observe, variance, start)
    still = np.zeros((STEPS, STATES, measured.shape[2]))
    inputs = still if inputs is None else inputs
    return whiten(transition, links, inputs, observe, measured, gains, spread), gains, spread


def scored(model, measured, inputs=None):
    """Return scores, informations, and slopes by variances."""
    white, gains, spread = filtered(model, measured, inputs)
    return adjoint(model[0], model[1], model[3], gains, spread, white)


def log_likelihood(model, measured, inputs=None):
    white, _, spread = filtered(model, measured, inputs)
    return -0.5 * float(np.nansum(white**2) + np.nansum(np.log(spread)))


def test_whitened_rows_have_the_chi_square_of_all_measurements_at_once(model):
    measured = np.random.default_rng(5).normal(size=(STEPS + 1, ROWS, 1))
    white, _, spread = filtered(model, measured)
    covariance, _, known = dense(model)
    rows = measured.ravel()[known]
    assert np.nansum(white**2) == pytest.approx(rows @ np.linalg.solve(covariance, rows))
    assert np.nansum(np.log(spread)) == pytest.approx(np.linalg.slogdet(covariance)[1])


@pytest.mark.parametrize("step", [0, 2])
def test_an_input_is_the_same_as_what_it_makes_visible(model, step):
    """An input of the first states alone, as a drive's are; the last state has none."""
    inputs = np.zeros((STEPS, STATES - 1, 1))
    inputs[step, 0, 0] = -1.0
    still = np.zeros((STEPS + 1, ROWS, 1))
    by_input, *_ = filtered(model, still, inputs)
    seen = still.copy()
    for moment in range(step + 1, STEPS + 1):
        seen[moment, :, 0] = model[3][moment, :, 0]
    by_sight, *_ = filtered(model, seen)
    np.testing.assert_allclose(by_input, by_sight, atol=1e-12)


@pytest.mark.parametrize("size", [1.0, -1.0])
def test_twice_the_measurements_or_inputs_give_twice_the_innovations(model, size):
    """From the first number that is not zero, also where all are the same."""
    measured, inputs = np.full((STEPS + 1, ROWS, 1), size), np.full((STEPS, STATES, 1), size)
    for u, z in ((inputs, 0.0 * measured), (0.0 * inputs, measured)):
        white, half = (filtered(model, factor * z, factor * u)[0] for factor in (1.0, 0.5))
        np.testing.assert_allclose(white, 2.0 * half, rtol=1e-12)
        assert np.any(white)


def test_the_adjoint_scores_a_push_as_a_regression_on_its_column_does(model):
    measured = np.random.default_rng(6).normal(size=(STEPS + 1, ROWS, 1))
    scores, informations, _ = scored(model, measured)
    assert (len(scores), len(informations)) == (STEPS, STEPS)
    covariance, pushes, known = dense(model)
    rows = measured.ravel()[known]
    for step in range(STEPS):
        expected = pushes[step] @ np.linalg.solve(covariance, rows)
        np.testing.assert_allclose(scores[step, :, 0], expected, atol=1e-9)
        expected = pushes[step] @ np.linalg.solve(covariance, pushes[step].T)
        np.testing.assert_allclose(informations[step], expected, atol=1e-9)


def test_the_adjoint_scores_are_the_slopes_of_the_likelihood_by_an_input(model):
    chance = np.random.default_rng(8)
    measured = chance.normal(size=(STEPS + 1, ROWS, 1))
    inputs = chance.normal(size=(STEPS, STATES, 1))
    scores, _, _ = scored(model, measured, inputs)
    for step in range(STEPS):
        for state in range(STATES):
            both = [inputs.copy(), inputs.copy()]
            both[0][step, state] += 1e-4
            both[1][step, state] -= 1e-4
            high, low = (log_likelihood(model, measured, own) for own in both)
            assert scores[step, state, 0] == pytest.approx((high - low) / 2e-4, abs=1e-6)


@pytest.mark.parametrize("columns", [1, 3])
def test_the_adjoint_gives_the_slopes_of_the_likelihood_by_every_variance(model, columns):
    measured = np.random.default_rng(9).normal(size=(STEPS + 1, ROWS, columns))
    transition, links, process, observe, variance, start = model
    scores, informations, by_variance = scored(model, measured)
    for moment, row in np.argwhere(np.isfinite(variance)):
        both = [variance.copy(), variance.copy()]
        both[0][moment, row] += 1e-5
        both[1][moment, row] -= 1e-5
        high, low = (
            log_likelihood((transition, links, process, observe, own, start), measured) for own in both
        )
        assert by_variance[moment, row] == pytest.approx((high - low) / 2e-5, rel=1e-5, abs=1e-7)
    for step in range(STEPS):
        both = [process.copy(), process.copy()]
        both[0][step, 1, 1] += 1e-5
        both[1][step, 1, 1] -= 1e-5
        high, low = (
            log_likelihood((transition, links, own, observe, variance, start), measured) for own in both
        )
        slope = 0.5 * ((scores[step, 1] ** 2).sum() - informations[step, 1, 1])
        assert slope == pytest.approx((high - low) / 2e-5, rel=1e-5, abs=1e-7)


def test_innovations_of_simulated_noise_are_white(model):
    """Of variance one, and none tells anything of another, in many draws of the model."""
    transition, _, process, observe, variance, start = model
    chance, draws = np.random.default_rng(10), 4000
    state = np.linalg.cholesky(start) @ chance.normal(size=(STATES, draws))
    measured = np.full((STEPS + 1, ROWS, draws), np.nan)
    for moment in range(STEPS + 1):
        if moment:
            root = np.linalg.cholesky(process[moment - 1] + 1e-12 * np.eye(STATES))
            state = transition[moment - 1] @ state + root @ chance.normal(size=(STATES, draws))
        noise = np.sqrt(variance[moment])[:, None] * chance.normal(size=(ROWS, draws))
        measured[moment] = observe[moment] @ state + noise
    white, *_ = filtered(model, measured)
    np.testing.assert_allclose(white @ white.T / draws, np.eye(len(white)), atol=5.0 / np.sqrt(draws))
