"""The filter whitens: the same likelihood, estimate and residuals as one large covariance matrix."""

import numpy as np
import pytest

from omnimate.calib.estimation.chains import Chains
from omnimate.calib.estimation.filtering import join_steps
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.reference import ReferenceProblem
from omnimate.vehicle.arcs import integrate
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import between, compose, wrap

MODEL = Differential(Truck(0.34, 0.15, 0.15))
VARIANCES = np.array([(2e-3) ** 2, (3e-3) ** 2, (5e-3) ** 2, 0.0])


@pytest.fixture(scope="module")
def chains() -> Chains:
    """A drive of 400 steps with eight fixes that err a little."""
    chance = np.random.default_rng(4)
    time = np.arange(401.0)
    rate = np.stack([0.2 + 0.1 * np.sin(time / 20), 0.2 + 0.1 * np.cos(time / 33)], axis=-1)
    readings = np.cumsum(rate, axis=0)
    path = integrate(MODEL.steps(readings, np.zeros(3)).increment, (0.3, -0.2, 0.5))
    at = np.linspace(0, 400, 8).astype(int)
    pose = path[at] + chance.normal(size=(8, 3)) * [3e-3, 3e-3, 5e-3]
    pose[:, 2] = wrap(pose[:, 2])
    drive = Drive(time, readings, time[at], pose, np.full((8, 3), np.nan), "test")
    return ReferenceProblem((drive,), MODEL).chains(np.zeros(3))


def dense(chains: Chains):
    """Residuals, their derivatives and covariance, with the start pose as three more parameters.

    All linear about the path through the first fix, as one large least-squares problem.
    """
    count = len(chains.first)
    path = [chains.measured[0]]
    for moved in chains.right[1:]:
        path.append(compose(path[-1], moved))
    path = np.array(path)
    residual = between(path, chains.measured)
    residual[:, 2] = wrap(residual[:, 2])
    design, spread = np.zeros((3 * count, 6)), np.zeros((3 * count, 3 * count))
    carried = {}
    for k in range(count):
        rows = slice(3 * k, 3 * k + 3)
        for j in range(k + 1):
            far = between(path[j], path[k])
            cos, sin = np.cos(far[2]), np.sin(far[2])
            carry = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
            carry[0, 2], carry[1, 2] = sin * far[0] - cos * far[1], cos * far[0] + sin * far[1]
            carried[k, j] = carry
        design[rows, 3:] = carried[k, 0]
        design[rows, :3] = sum(carried[k, j] @ chains.sensitivity[j] for j in range(1, k + 1)) if k else 0.0
    for k in range(count):
        for i in range(count):
            block = np.zeros((3, 3))
            for j in range(1, min(i, k) + 1):
                block += carried[k, j] @ (VARIANCES[0] * chains.process[0, j]) @ carried[i, j].T
            spread[3 * k : 3 * k + 3, 3 * i : 3 * i + 3] = block
    spread += np.diag(np.tile([VARIANCES[1], VARIANCES[1], VARIANCES[2]], count))
    return residual.ravel(), design, spread


@pytest.mark.slow
def test_the_estimate_is_that_of_one_large_least_squares_problem(chains):
    residual, design, spread = dense(chains)
    weighed = np.linalg.solve(spread, design)
    expected = np.linalg.solve(design.T @ weighed, weighed.T @ residual)[:3]
    bound = np.linalg.inv(design.T @ weighed)[:3, :3]
    filtered, _ = chains.filtered(VARIANCES, np.ones(8))
    slope, value = filtered.innovation[:, :, 1:], filtered.innovation[:, :, 0]
    white = filtered.precision @ slope
    information = np.einsum("kip,kiq->pq", slope, white)
    found = -np.linalg.solve(information, np.einsum("kip,ki->p", white, value))
    sigma = np.sqrt(np.diag(bound))
    np.testing.assert_allclose(np.sqrt(np.diag(np.linalg.inv(information))), sigma, rtol=0.02)
    np.testing.assert_allclose(found / sigma, expected / sigma, atol=0.05)


def test_auxiliary_residuals_are_the_whitened_ones(chains):
    """u = V^-1 (y - what the start pose explains), with covariance V^-1 less what the start takes."""
    residual, design, spread = dense(chains)
    start = design[:, 3:]
    inverse = np.linalg.inv(spread)
    taken = inverse @ start @ np.linalg.solve(start.T @ inverse @ start, start.T @ inverse)
    precision = inverse - taken
    _, smoothed = chains.filtered(VARIANCES, np.ones(8))
    for k in range(8):
        rows = slice(3 * k, 3 * k + 3)
        np.testing.assert_allclose(smoothed.fix_precision[k], precision[rows, rows], rtol=0.05, atol=300.0)
    sizes = np.sqrt(np.diag(precision)).reshape(8, 3)
    expected = (precision @ residual).reshape(8, 3)
    np.testing.assert_allclose(smoothed.fix[:, :, 0] / sizes, expected / sizes, atol=0.05)


def test_chains_do_not_know_of_each_other(chains):
    twice = Chains(
        *(np.concatenate([getattr(chains, name)] * 2) for name in Chains._fields[:5]),
        np.concatenate([chains.process] * 2, axis=1),
        np.concatenate([chains.measured] * 2),
        np.concatenate([chains.stated] * 2),
        np.concatenate([chains.scatter] * 2, axis=1),
        chains.lever,
        np.concatenate([chains.effect] * 2),
    )
    one, two = (it.filtered(VARIANCES, np.ones(len(it.first))) for it in (chains, twice))
    for alone, both in zip([*one[0], *one[1]], [*two[0], *two[1]], strict=True):
        np.testing.assert_array_equal(both, np.concatenate([alone, alone]))


def test_steps_join_to_the_movement_that_integration_gives():
    chance = np.random.default_rng(0)
    readings = np.cumsum(chance.normal(0.1, 0.2, (31, 2)), axis=0)
    steps = MODEL.steps(readings, np.zeros(3))
    moved, slope, process = join_steps(np.array([0.0, 10.0]), np.array([10.0, 30.0]), *steps)
    path = integrate(steps.increment)
    np.testing.assert_allclose(moved, [path[10], between(path[10], path[30])], atol=1e-12)
    for coordinate in range(3):
        step = np.zeros(3)
        step[coordinate] = 1e-6
        ends = [integrate(MODEL.steps(readings[10:], sign * step).increment)[-1] for sign in (-1, 1)]
        np.testing.assert_allclose(slope[1, :, coordinate], between(*ends) / 2e-6, atol=1e-7)
    assert np.linalg.eigvalsh(process[0, 1]).min() > 0.0
