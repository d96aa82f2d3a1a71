"""Whether the size of an effect is the same all over a drive, as its law says.

What an effect explains, times a quantity of the drive, must explain nothing more: a coefficient is tested
against one that varies with that quantity (Hastie & Tibshirani, Varying-coefficient models, J. Royal
Statistical Society B 55, 1993). That sizes differ from one stretch of time to the next by the law's declared
discrepancy is noise there. A wrong name that resembles the true physics in one manoeuvre fails here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from omnimate.mismatch.candidates.quantities import shared_quantities
from omnimate.mismatch.evidence.rows import apply_discrepancy, discrepancy_factor, products_by_group

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.fit import Fitted
    from omnimate.vehicle.se2 import Array

ERROR_RATE = 0.01  # declared: one right name in a hundred is said to vary
SEPARABLE = 1e-3  # share of a column's square below which the effects and the calibration hold all of it


def varying_sizes(fit: Fitted, parts: Sequence[Array], stretch: NDArray[np.int64]) -> list[bool]:
    """Say of each effect of a fit whether its size varies with some quantity of the drive.

    What acts for a while only is not tested.

    Args:
        fit: The effects.
        parts: What each explains of the data, `(V,)`.
        stretch: Number of each row's stretch of time, `(V,)`.
    """
    rows = fit.rows
    columns, _ = fit.linear_model(rows)
    fitted = np.column_stack([columns, rows[:, 0]])
    curves = _curves_at_rows(fit.regression)
    return [
        not term.is_local and _varies(part, term.discrepancy, fitted, curves, stretch)
        for term, part in zip(fit.chosen.terms, parts, strict=True)
    ]


def _varies(
    part: Array, discrepancy: float, fitted: Array, curves: Sequence[Array], stretch: NDArray[np.int64]
) -> bool:
    """Say whether a part (V,) varies with one of the curves (V, k).

    Args:
        part: What the effect explains of the data.
        discrepancy: Of its law.
        fitted: Columns of all that is fitted, and last what the fit leaves, `(V, K + 1)`.
        curves: Of each quantity.
        stretch: Number of each row's stretch.
    """
    factor = discrepancy_factor(discrepancy * part[:, None], stretch)
    fitted = apply_discrepancy(fitted, factor)
    axes, sizes, _ = np.linalg.svd(fitted[:, :-1], full_matrices=False)
    axes = axes[:, sizes > 1e-8 * sizes[0]]
    left = fitted[:, -1] - axes @ (axes.T @ fitted[:, -1])
    own = part / max(float(np.linalg.norm(part)), 1e-12)
    p_values = []
    for curve in curves:
        varied = own[:, None] * curve
        tested = apply_discrepancy(varied, factor)
        tested = tested - axes @ (axes.T @ tested)
        tested = tested[:, (tested**2).sum(axis=0) > SEPARABLE * (varied**2).sum(axis=0) + 1e-12]
        if tested.shape[1]:
            p_values.append(_p_value(tested, left, stretch))
    return bool(p_values) and min(p_values) * len(p_values) < ERROR_RATE


def _p_value(columns: Array, data: Array, stretch: NDArray[np.int64]) -> float:
    """Return the p-value of the score test that columns (V, k) explain nothing of the data (V,).

    The variance of scores is that of white noise, or that of scores of stretches where this is more careful
    (White, Econometrica 1982).
    """
    _, scores = products_by_group(stretch, columns, data)
    score = scores.sum(axis=0)
    squares = [
        float(score @ np.linalg.pinv(variance, hermitian=True) @ score)
        for variance in (columns.T @ columns, scores.T @ scores)
    ]
    return float(chi2.sf(min(squares), len(score)))


def _curves_at_rows(regression: Regression) -> list[Array]:
    """Return of each quantity its curves at the ends of the rows' windows, each about its mean, `(V, k)`."""
    recordings = shared_quantities([windows.signals for windows in regression.windows])
    found = []
    for name in recordings[0]:
        values = [
            np.stack(curves[name], axis=1)[np.maximum(windows.ends - 1, 0)][
                regression.moment[regression.owner == number]
            ]
            for number, (windows, curves) in enumerate(zip(regression.windows, recordings, strict=True))
        ]
        there = np.concatenate(values)
        found.append(np.asarray(there - there.mean(axis=0)))
    return found
