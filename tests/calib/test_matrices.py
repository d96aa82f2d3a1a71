"""The small compiled matrices agree with numpy."""

import numpy as np
import pytest

from calib import matrices
from vehicle.se2 import between, compose, inverse


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


def test_transport_carries_a_small_error_over_an_increment(chance):
    increment, error = chance.normal(size=3), 1e-7 * chance.normal(size=3)
    out = np.empty((3, 3))
    matrices.transport(out, increment)
    after = compose(inverse(increment), compose(error, increment))
    np.testing.assert_allclose(out @ error, after, atol=1e-12)


def test_joining_may_overwrite_its_arguments(chance):
    first, second = chance.normal(size=3), chance.normal(size=3)
    expected = compose(first, second)
    matrices.join(first, first, second)
    np.testing.assert_allclose(first, expected)


def test_rotation_turns_the_world_into_a_frame():
    out = np.empty((3, 3))
    matrices.rotation(out, 0.3)
    np.testing.assert_allclose(out @ [1.0, 2.0, 3.0], [*between([0, 0, 0.3], [1.0, 2.0, 0])[:2], 3.0])
