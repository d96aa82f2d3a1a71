"""The small compiled matrices agree with numpy."""

import numpy as np
import pytest

from omnimate.vehicle import matrices


@pytest.fixture
def chance():
    return np.random.default_rng(0)


def positive(chance, size):
    half = chance.normal(size=(size, size))
    return half @ half.T


def test_products_are_those_of_numpy(chance):
    one, other, vector = chance.normal(size=(3, 3)), chance.normal(size=(3, 5)), chance.normal(size=5)
    out = np.empty((3, 5))
    matrices.product(out, one, other)
    np.testing.assert_allclose(out, one @ other)
    matrices.product(out, one.T, other)
    np.testing.assert_allclose(out, one.T @ other)
    rest = np.empty((3, 3))
    matrices.complement(rest, one, other[:, :3])
    np.testing.assert_allclose(rest, np.eye(3) - one @ other[:, :3], atol=1e-15)
    inside, drawn = positive(chance, 5), np.empty(5)
    vector[2] = 0.0
    matrices.multiply(drawn, inside, vector)
    np.testing.assert_allclose(drawn, inside @ vector)


def test_a_sandwich_adds_a_symmetric_product(chance):
    one, inside, out = chance.normal(size=(3, 3)), positive(chance, 3), np.eye(3)
    matrices.sandwich(out, one, inside)
    np.testing.assert_allclose(out, np.eye(3) + one @ inside @ one.T)


def test_inverses_undo_positive_matrices_of_very_different_scales(chance):
    scale = np.array([1e-6, 1.0, 1e4])
    matrix, out = positive(chance, 3) * np.outer(scale, scale), np.empty((3, 3))
    matrices.invert_into(out, matrix)
    in_place = matrix.copy()
    matrices.invert(in_place)
    for inverse in (out, in_place):
        np.testing.assert_allclose((inverse @ matrix) * scale[:, None] / scale, np.eye(3), atol=1e-6)
        assert np.array_equal(inverse, inverse.T)
