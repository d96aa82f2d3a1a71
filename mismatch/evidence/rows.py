"""Whitened rows that are whitened anew: with nuisances being noise, or effects whose laws are not exact."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.se2 import Array


def shrinking(inside: Array) -> Array:
    """Return the matrix S (k, k) by which (1 + N N')^-1/2 = 1 - N S N', of the products N'N of nuisances."""
    sizes, axes = np.linalg.eigh(inside)
    sizes = np.maximum(sizes, 1e-12)
    return np.asarray((axes * ((1.0 - 1.0 / np.sqrt(1.0 + sizes)) / sizes)) @ axes.T)


def free(rows: Array, nuisance: Array) -> Array:
    """Return rows (V, C) whitened anew, nuisances (V, k) of unit size being noise."""
    return np.asarray(rows - nuisance @ (shrinking(nuisance.T @ nuisance) @ (nuisance.T @ rows)))


def narrowed(rows: Array, nuisance: Array) -> Array:
    """Return rows (V, C) with nuisances (V, k), no longer noise: the inverse of `shrinking`."""
    sizes, axes = np.linalg.eigh(nuisance.T @ nuisance)
    sizes = np.clip(sizes, 1e-12, 1.0 - 1e-9)
    grown = axes * ((1.0 / np.sqrt(1.0 - sizes) - 1.0) / sizes)
    return np.asarray(rows + nuisance @ (grown @ (axes.T @ (nuisance.T @ rows))))


def loosened(rows: Array, by: csr_array) -> Array:
    """Return rows (V, C) whitened anew by what `loosening` gave."""
    return np.asarray(rows - by @ (by.T @ rows))


def loosening(part: Array, stretch: NDArray[np.int64]) -> csr_array:
    """Return B (V, n) by which rows are whitened anew where parts (V, k) are of any size in a stretch.

    The noise of a stretch is then 1 + part part', and its inverse root is 1 - B B'.
    """
    order = np.argsort(stretch, kind="stable")
    edges = np.searchsorted(stretch[order], np.arange(int(stretch.max()) + 2))
    rows, columns, values, count = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)], 0
    for start, end in itertools.pairwise(edges.tolist()):
        mine = order[start:end]
        if float((part[mine] ** 2).sum()) < 1e-3:
            continue
        axes, sizes, _ = np.linalg.svd(part[mine], full_matrices=False)
        axes = axes * np.sqrt(1.0 - 1.0 / np.sqrt(1.0 + sizes**2))
        rows.append(np.repeat(mine, axes.shape[1]))
        columns.append(np.tile(count + np.arange(axes.shape[1]), len(mine)))
        values.append(axes.ravel())
        count += axes.shape[1]
    where = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), where), shape=(len(part), count))


def products_by_group(group: NDArray[np.int64], columns: Array, data: Array) -> tuple[Array, Array]:
    """Return products of columns (V, k) with each other (G, k, k) and the data (G, k), in each group of rows.

    Args:
        group: Number of each row's group, `(V,)`.
        columns: The columns.
        data: The data, `(V,)`.
    """
    count, width = int(group.max()) + 1, columns.shape[1]
    gram, score = np.empty((count, width, width)), np.empty((count, width))
    for first in range(width):
        score[:, first] = np.bincount(group, weights=columns[:, first] * data, minlength=count)
        for other in range(first, width):
            inside = np.bincount(group, weights=columns[:, first] * columns[:, other], minlength=count)
            gram[:, first, other] = gram[:, other, first] = inside
    return gram, score
