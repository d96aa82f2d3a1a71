"""The small compiled matrices agree with numpy."""

import numpy as np
import pytest

from omnimate.calib.estimation import matrices


@pytest.fixture
def chance():
    return np.random.default_rng(0)


def test_products_are_those_of_numpy(chance):
    one, other = chance.normal(size=(3, 3)), chance.normal(size=(3, 5))
    out = np.empty((3, 5))
    matrices.product(out, one, other)
    np.testing.assert_allclose(out, one @ other)
    matrices.product_of_transposed(out, one, other)
    np.testing.assert_allclose(out, one.T @ other)


def test_sandwiches_add_a_symmetric_product(chance):
    one, half = chance.normal(size=(3, 3)), chance.normal(size=(3, 3))
    inside = half @ half.T
    out = np.eye(3)
    matrices.sandwich(out, one, inside)
    np.testing.assert_allclose(out, np.eye(3) + one @ inside @ one.T)
    out = np.eye(3)
    matrices.sandwich_of_transposed(out, one, inside)
    np.testing.assert_allclose(out, np.eye(3) + one.T @ inside @ one)


def test_the_inverse_undoes_a_positive_matrix_of_very_different_scales(chance):
    half = chance.normal(size=(3, 3)) * [[1e-6], [1.0], [1e4]]
    matrix, out = half @ half.T, np.empty((3, 3))
    matrices.inverse(out, matrix)
    scale = np.sqrt(np.diag(matrix))
    np.testing.assert_allclose((out @ matrix) * scale[:, None] / scale, np.eye(3), atol=1e-6)
