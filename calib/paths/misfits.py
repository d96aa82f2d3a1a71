"""Drives that do not fit the others of their set, and why: swapped wheels, or another clock."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.advice import Advice
from omnimate.calib.distributions import MAD_TO_SIGMA
from omnimate.calib.errors import CalibrationError
from omnimate.calib.estimation.residuals import Residuals, outlier_weights

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.calib.paths.reference import ReferenceProblem
    from omnimate.vehicle.se2 import Array

_ROUNDS = 6  # in which outliers lose their weight
_TENFOLD = float(np.log(10.0))  # squared residuals of a run over the median run's, for it to be left out
_HOPELESS = 100.0  # squared distance from which on no drive fits, and a cause is looked for
_BETTER = 10.0  # times smaller must a squared distance be with an error corrected, for it to be the cause
_SHIFTS = np.delete(np.arange(-20, 21), 20) / 10.0  # [s] errors of the clock that are tried
_LIMIT = 3.5  # [standard deviations] beyond it, a number is an outlier: Iglewicz & Hoaglin (1993)
_FEWEST = 3  # runs from which on one can differ from the others
_MEDIAN = 0.79  # median of chi^2 per degree of freedom, for three degrees


def squared_distances(problem: ReferenceProblem, coordinates: Array) -> Array:
    """Return the median squared distance of each drive's fixes from the prediction by all others, `(N,)`.

    It is per degree of freedom, with the noise of a good measurement: about 1 of a drive that fits.
    """
    chains = problem.chains(coordinates)
    variances = np.array([noise.guess**2 for noise in problem.noises])
    none = np.zeros(len(coordinates))
    known = np.isfinite(chains.measured).sum(axis=1)
    weights = np.ones(len(known))
    for _ in range(_ROUNDS):
        ahead, behind = chains.filtered(variances, weights)
        now = Residuals(chains, ahead.heading, behind, none, np.zeros((len(none), len(none))))
        square = now.distances(variances, weights)
        weights = np.sqrt(weights * outlier_weights(square, known))
    parts = np.split(square / (_MEDIAN * known), np.flatnonzero(chains.first)[1:])
    return np.array([np.median(part) for part in parts])


def without_misfits(
    problem: ReferenceProblem, coordinates: Array
) -> tuple[ReferenceProblem, tuple[Advice, ...]]:
    """Return a problem without the drives that fit the coordinates much worse than the others, and which.

    Raises:
        CalibrationError: No drive fits, and there is a cause: swapped wheels, or a wrong clock.
    """
    squares = np.maximum(squared_distances(problem, coordinates), 1.0)
    outlying = _outlying(np.log(squares))
    if np.median(squares) > _HOPELESS:
        cause = _cause(problem, coordinates)
        if cause is not None and not (problem.with_time and "clock" in cause):
            raise CalibrationError(problem.source, f"poses and wheels do not fit each other: {cause}")
    advice = []
    for number in np.flatnonzero(outlying):
        alone = replace(problem, drives=(problem.drives[number],))
        why = _cause(alone, coordinates) or "is it of this robot, on this floor, with this clock?"
        times = math.sqrt(squares[number] / np.median(squares))
        what = (
            f"{alone.source} is left out: its poses are {times:.0f} times as far off as those of the others"
        )
        advice.append(Advice("warning", what, why))
    kept = tuple(drive for drive, out in zip(problem.drives, outlying, strict=True) if not out)
    return replace(problem, drives=kept), tuple(advice)


def _outlying(values: Array) -> NDArray[np.bool_]:
    """Return which of N numbers `(N,)` lie above the median by 3.5 robust standard deviations and `_TENFOLD`.

    The standard deviation is that of the median absolute deviation, which fewer than half of the runs cannot
    change; of few runs it may be small by chance, so that a distance is required as well.
    """
    if len(values) < _FEWEST:
        return np.zeros(len(values), bool)
    away = values - np.median(values)
    sigma = MAD_TO_SIGMA * float(np.median(np.abs(away)))
    return np.asarray(away > max(_LIMIT * sigma, _TENFOLD), bool)


def _cause(problem: ReferenceProblem, coordinates: Array) -> str | None:
    """Return the single error of all drives whose correction makes them fit, in words; None without one."""
    swapped = [replace(drive, readings=drive.readings[:, ::-1]) for drive in problem.drives]
    causes = {"the left and the right wheel are swapped": swapped}
    for shift in _SHIFTS:
        words = f"the clock of the poses is {abs(shift):.1f} s {'ahead' if shift > 0.0 else 'behind'}"
        words += "; shift poses.csv, or estimate the delay (--time-offset)"
        causes[words] = [replace(drive, fix_time=drive.fix_time - shift) for drive in problem.drives]
    squares = {
        words: float(np.median(squared_distances(replace(problem, drives=tuple(drives)), coordinates)))
        for words, drives in causes.items()
    }
    best = min(squares, key=squares.__getitem__)
    now = float(np.median(squared_distances(problem, coordinates)))
    return best if now > _BETTER * max(squares[best], 1.0) else None
