"""Further whitening of whitened rows, with nuisances or discrepancies of laws as noise; sums over groups."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array


NEGLIGIBLE = 1e-6  # variance that nuisances add to the noise along an axis, over the noise's own


def nuisance_noise(gram: Array) -> tuple[Array, Array]:
    """Return what nuisances of unit size add to the noise, of their products N'N (n, n): N N' = A D A'.

    Returns:
        The diagonal of D `(r,)`, and what each of r axes has of every nuisance, of unit length, `(n, r)`; A
        is N times these, divided by the roots of D. Most nuisances hardly differ: axes without noise are left
        out.
    """
    variances, directions = np.linalg.eigh(gram)
    kept = variances > NEGLIGIBLE
    return variances[kept], directions[:, kept]


def whiten_nuisances(rows: Array, nuisance: Array) -> Array:
    """Return rows (V, C) whitened with nuisances (V, k) of unit size as noise."""
    variances, directions = nuisance_noise(nuisance.T @ nuisance)
    axes = nuisance @ (directions / np.sqrt(variances))
    return whiten_along(rows, axes, variances, axes.T @ rows)


def whiten_along(rows: Array, axes: Array, variances: Array, along: Array) -> Array:
    """Return rows (V, C) whitened with noise of variances (r,) in addition along axes (V, r) of unit length.

    `along` (r, C) are their products with the axes.
    """
    return np.asarray(rows - axes @ ((1.0 - 1.0 / np.sqrt(1.0 + variances))[:, None] * along))


def unwhiten_nuisances(rows: Array, nuisance: Array) -> Array:
    """Return rows (V, C) with nuisances (V, k) no longer noise: the inverse of `whiten_nuisances`."""
    sizes, axes = np.linalg.eigh(nuisance.T @ nuisance)
    sizes = np.clip(sizes, 1e-12, 1.0 - 1e-9)
    grown = axes * ((1.0 / np.sqrt(1.0 - sizes) - 1.0) / sizes)
    return np.asarray(rows + nuisance @ (grown @ (axes.T @ (nuisance.T @ rows))))


def apply_discrepancy(rows: Array, factor: csr_array) -> Array:
    """Return rows (V, C) whitened by a factor from `discrepancy_factor`."""
    return np.asarray(rows - factor @ (factor.T @ rows))


def discrepancy_factor(part: Array, stretch: NDArray[np.int64]) -> csr_array:
    """Return B (V, n) such that 1 - B B' whitens noise 1 + part part' in each stretch, of parts (V, k)."""
    order = np.argsort(stretch, kind="stable")
    edges = np.searchsorted(stretch[order], np.arange(int(stretch.max()) + 2))
    row_numbers, columns, values, count = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)], 0
    for start, end in itertools.pairwise(edges.tolist()):
        rows_of_stretch = order[start:end]
        if float((part[rows_of_stretch] ** 2).sum()) < 1e-7:
            continue
        axes, sizes, _ = np.linalg.svd(part[rows_of_stretch], full_matrices=False)
        axes = axes * np.sqrt(1.0 - 1.0 / np.sqrt(1.0 + sizes**2))
        row_numbers.append(np.repeat(rows_of_stretch, axes.shape[1]))
        columns.append(np.tile(count + np.arange(axes.shape[1]), len(rows_of_stretch)))
        values.append(axes.ravel())
        count += axes.shape[1]
    where = np.concatenate(row_numbers), np.concatenate(columns)
    return csr_array((np.concatenate(values), where), shape=(len(part), count))


def products_by_group(group: NDArray[np.int64], columns: Array, data: Array) -> tuple[Array, Array]:
    """Return products of columns (V, k) with each other (G, k, k) and data (G, k), in each group of rows."""
    count, width = int(group.max()) + 1, columns.shape[1]
    gram, score = np.empty((count, width, width)), np.empty((count, width))
    for first in range(width):
        score[:, first] = np.bincount(group, weights=columns[:, first] * data, minlength=count)
        for other in range(first, width):
            products = np.bincount(group, weights=columns[:, first] * columns[:, other], minlength=count)
            gram[:, first, other] = gram[:, other, first] = products
    return gram, score
