"""Changes: whether a robot's history deviates from nominal variation, since when, in what, and how fast.

The null hypothesis is a healthy robot of its type (`omnimate.fleet.model.histories`), one quantity of which
may be an outlier on a single day: somebody pushes it, a load shifts. Each alternative adds a step or a ramp
to one quantity from one day on. The evidence is the mixture of the alternatives' likelihoods over that of the
null: an e-value, whose mean is at most 1 on healthy robots. The faulty robots of a day are chosen by the e-BH
procedure, which keeps the expected fraction of false ones among them below a level, whatever the dependence
among robots (Wang & Ramdas, False discovery rate control with e-values, JRSS B 2022).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.special import logsumexp

from omnimate.fleet.report import Change, Shape

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.fleet.model.histories import History, NominalVariation
    from omnimate.vehicle.se2 import Array

SIZE_GRID = (5.0, 20.0, 80.0)  # [standard deviations of a day] prior scales of a change (assumption)
RAMP_DAYS = 5.0  # [days] in which a ramp reaches such a size (assumption)
OUTLIER_PROBABILITY = 0.02  # probability that a healthy robot's history has an outlier (assumption)
MIN_DAYS = 3  # [days] of a history that are needed to detect a change
FALSE_DISCOVERY_RATE = 0.01  # expected fraction of healthy robots among those reported as faulty


def detect_change(history: History, nominal: NominalVariation) -> Change | None:
    """Return the most probable change in a history; None if that has fewer than `MIN_DAYS` days.

    The size has a normal prior with each of the scales in `SIZE_GRID`, in the mean of which it is integrated
    out.
    """
    count, size = history.value.shape
    if count < MIN_DAYS:
        return None
    factor = cholesky(nominal.covariance(history), lower=True)
    whitened = solve_triangular(factor, (history.value - nominal.mean(history)).reshape(-1), lower=True)
    shapes = np.concatenate([_shapes(history.days), np.eye(count)])  # (A + D, D), with A = 2 (D - 1)
    columns = np.zeros((count, size, len(shapes), size))
    columns[:, np.arange(size), :, np.arange(size)] = shapes.T * nominal.sigma[:, np.newaxis, np.newaxis]
    whitened_columns = solve_triangular(factor, columns.reshape(count * size, -1), lower=True)
    information = (whitened_columns**2).sum(axis=0).reshape(len(shapes), size)
    score = (whitened_columns.T @ whitened).reshape(len(shapes), size)
    variance = np.array(SIZE_GRID)[:, np.newaxis, np.newaxis] ** 2
    logs = 0.5 * (score**2 * variance / (1.0 + variance * information) - np.log1p(variance * information))
    changed, outlier = logs[:, :-count], logs[:, -count:]
    healthy = np.logaddexp(0.0, logsumexp(outlier) + math.log(OUTLIER_PROBABILITY / (len(SIZE_GRID) * size)))
    log_e = float(logsumexp(changed) - math.log(changed.size) - healthy)
    odds = np.exp(changed - changed.max()).sum(axis=0)  # (A, P)
    quantity = int(np.argmax(odds.sum(axis=0)))
    shape_odds = odds[:, quantity]
    best = int(np.argmax(shape_odds))
    onsets = shape_odds.reshape(2, -1).sum(axis=0)
    cumulative = np.cumsum(onsets) / onsets.sum()
    first, last = (int(np.searchsorted(cumulative, quantile)) + 1 for quantile in (0.05, 0.95))
    unit = float(nominal.sigma[quantity])
    amount = score[best, quantity] / (information[best, quantity] + 1.0 / SIZE_GRID[-1] ** 2) * unit
    sigma = unit / math.sqrt(information[best, quantity])
    shape: Shape = "step" if best < count - 1 else "ramp"
    last_value = float(shapes[best, -1])
    return Change(
        history.robot,
        history.kind,
        log_e,
        history.names[quantity],
        float(shape_odds.sum() / odds.sum()),
        history.dates[best % (count - 1) + 1],
        history.dates[first],
        history.dates[min(last, count - 1)],
        shape,
        float(amount) * last_value,
        sigma * last_value,
        float(amount) / RAMP_DAYS if shape == "ramp" else 0.0,
    )


def select_faulty(changes: Sequence[Change], level: float = FALSE_DISCOVERY_RATE) -> list[Change]:
    """Return the changes of the faulty robots, the most significant first, by the e-BH procedure.

    The level is the allowed expected fraction of healthy robots among those returned [0 to 1].
    """
    ordered = sorted(changes, key=lambda change: -change.log_e)
    passed = [
        number
        for number, change in enumerate(ordered, start=1)
        if change.log_e >= math.log(len(ordered) / (level * number))
    ]
    return ordered[: max(passed, default=0)]


def detect_changes(histories: Sequence[History], nominal: Mapping[str, NominalVariation]) -> list[Change]:
    """Return the most probable change of each robot with enough days; `nominal` is by type."""
    changes = (detect_change(history, nominal[history.kind]) for history in histories)
    return [change for change in changes if change is not None]


def _shapes(days: Array) -> Array:
    """Return unit steps that begin on each day but the first, and then such ramps, `(2 (D - 1), D)`."""
    since = days - days[1:, np.newaxis]
    steps = np.where(since >= 0.0, 1.0, 0.0)
    ramps = np.where(since >= 0.0, since + 1.0, 0.0) / RAMP_DAYS
    return np.concatenate([steps, ramps])
