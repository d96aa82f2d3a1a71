"""Other ways to learn what has no name, from the same rows: a Gaussian process of all variables, and pysindy.

Both see what a law sees: the variables of the drive, and what an error series does to whitened rows. Each
answers with a function from the variables of any drive to the error.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from omnimate.mismatch.learn.evidence import Products
from omnimate.vehicle.se2 import Array

Variables = Mapping[str, Array]
Learned = Callable[[Variables], Array]
Columns = Callable[[Array], Array]

FEATURES = 300  # of a Gaussian process
LENGTHS = (0.5, 1.0, 2.0, 4.0, 8.0)  # of its kernel, in standard deviations of the variables
SIZES = (0.25, 1.0, 4.0, 16.0)  # of its error, in the a-priori size of a law
THRESHOLDS = (0.03, 0.1, 0.3, 1.0, 3.0)  # of sequential least squares, likewise
GROUPS = 3  # of folds, which are left out in turn
RIDGE = 1.0  # for columns in whitened rows, in the a-priori size of a law
SINDY = "pysindy"


def has_sindy() -> bool:
    return find_spec(SINDY) is not None


def gaussian_process(
    variables: Variables, columns: Columns, rows: Array, folds: NDArray[np.int64], scale: float
) -> Learned:
    """Return the mean of a Gaussian process of all variables, with a squared-exponential kernel.

    It is a linear model of random Fourier features (Rahimi and Recht, Advances in Neural Information
    Processing Systems 20, 2007); length and size are those of the largest evidence.
    """
    chance = np.random.default_rng(1)
    plain = _standardised(variables, variables)
    draw, phase = chance.standard_normal((plain.shape[1], FEATURES)), chance.uniform(0.0, math.tau, FEATURES)
    best: tuple[float, float, Array] = (-math.inf, 1.0, np.zeros(FEATURES))
    members = np.arange(FEATURES)
    for length in LENGTHS:
        basis = math.sqrt(2.0 / FEATURES) * np.cos(plain @ draw / length + phase)
        products = Products.of(columns(basis), rows, folds)
        for size in SIZES:
            spread = np.full(FEATURES, scale * size)
            evidence = float(products.evidence(members[None], spread[None], left_out=False)[0, 0])
            if evidence > best[0]:
                best = evidence, length, products.posterior(members, spread)[0]
    _, length, weights = best

    def learned(values: Variables) -> Array:
        at = _standardised(values, variables)
        return np.asarray(math.sqrt(2.0 / FEATURES) * np.cos(at @ draw / length + phase) @ weights)

    return learned


def sindy(
    variables: Variables, columns: Columns, rows: Array, folds: NDArray[np.int64], scale: float
) -> Learned:
    """Return what pysindy finds: sequentially thresholded least squares of polynomials and waves.

    The threshold is the one of the least error in three groups of folds that are left out in turn.
    """
    package = import_module(SINDY)
    library = package.PolynomialLibrary(degree=2) + package.FourierLibrary(n_frequencies=2)
    plain = _standardised(variables, variables)
    library.fit(plain)
    basis = np.asarray(library.transform(plain))
    size = np.sqrt(np.mean(basis**2, axis=0))
    seen = scale * columns(basis / size)

    groups = folds % GROUPS

    def weights(threshold: float, kept: NDArray[np.bool_]) -> Array:
        optimizer = package.STLSQ(threshold=threshold, alpha=RIDGE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a threshold leaves no coefficient is an answer, too
            optimizer.fit(seen[kept], rows[kept, None])
        coefficients: Array = np.asarray(optimizer.coef_, np.float64)[0]
        return coefficients

    def missed(threshold: float) -> float:
        left = [
            rows[groups == own] - seen[groups == own] @ weights(threshold, groups != own)
            for own in range(GROUPS)
        ]
        return sum(float(part @ part) for part in left)

    errors = [missed(threshold) for threshold in THRESHOLDS]
    coefficients = weights(THRESHOLDS[int(np.argmin(errors))], np.ones(len(rows), bool))
    if min(errors) > float(rows @ rows):
        coefficients = np.zeros_like(coefficients)
    return lambda own: np.asarray(
        scale * (np.asarray(library.transform(_standardised(own, variables))) / size) @ coefficients
    )


def _standardised(variables: Variables, of: Variables) -> Array:
    """Return variables `(N, v)` in units of their deviation in a drive; angles that go round as waves."""
    columns = []
    for name, values in of.items():
        if float(np.ptp(values)) == 0.0:
            continue
        if name.startswith(("wheel_angle", "heading")):
            columns += [np.cos(variables[name]), np.sin(variables[name])]
        else:
            columns.append((variables[name] - values.mean()) / values.std())
    return np.stack(columns, axis=1)
