"""What a nominal robot misses on a nominal floor: an error without a name that changes less is a trace.

Every floor repeats itself in the next lap, and no robot is exact. Fine sensors on a smooth floor show of that
what is no mismatch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.mismatch.answer.rerun import STRETCH
from omnimate.mismatch.heldout import size
from omnimate.mismatch.noise.levels import (
    LOG_LEVEL_SIGMA,
    NoiseLevels,
    filter_of,
    nominal_levels,
    open_loop_variance,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.noise.levels import Filter
    from omnimate.vehicle.se2 import Array


def innovation_variance(filters: Sequence[Filter], levels: NoiseLevels) -> Array:
    """Return the variance that each row's innovation has at noise levels, `(V,)`; 1 is the filters' own."""
    ratios = [filter_of(kalman.windows, levels).spread / kalman.spread for kalman in filters]
    return np.concatenate([ratio[np.isfinite(ratio)] for ratio in ratios])


def usual_levels(regression: Regression) -> NoiseLevels:
    """Return a robot's own noise levels, at least nominal and at most those of a usual robot.

    A level beyond them is no noise of sensors or floor: the mismatch that is asked about may be in it.
    """
    nominal = nominal_levels(regression.windows).levels()
    usual = np.clip(regression.noise.levels(), nominal, nominal + LOG_LEVEL_SIGMA)
    return NoiseLevels(*np.exp(usual).tolist())


def roughest_levels(regression: Regression) -> NoiseLevels:
    """Return a robot's own noise levels, at least the largest of a usual robot."""
    largest = nominal_levels(regression.windows).levels() + LOG_LEVEL_SIGMA
    return NoiseLevels(*np.exp(np.maximum(regression.noise.levels(), largest)).tolist())


def innovations(regression: Regression) -> dict[str, float]:
    """Return by how much a nominal robot misses each channel from one reading to the next, rms; 1 is own."""
    variance = innovation_variance(regression.filters, nominal_levels(regression.windows))
    channel = regression.channel
    names = regression.windows[0].names
    return {names[number]: size(variance[channel == number] ** 0.5) for number in np.unique(channel)}


def open_loop(regression: Regression) -> dict[str, float]:
    """Return by how much a nominal robot misses each channel open loop, rms [m, rad], named as in `rerun`."""
    levels = nominal_levels(regression.windows)
    misses: dict[str, list[Array]] = {}
    for windows in regression.windows:
        starts = np.arange(windows.time[0], windows.time[-1], STRETCH)
        edges = np.append(np.searchsorted(windows.time, starts), len(windows.time) - 1)
        variance, linkage = open_loop_variance(windows, levels, edges.tolist()).T, windows.linkage
        columns = dict(zip(LINKAGE, variance[:linkage], strict=False))
        for number, truck in enumerate(windows.signals.trucks):
            x, y, heading = variance[windows.pose_rows(number)]
            columns |= {f"{truck} position": x + y, f"{truck} heading": heading}
        for name, column in columns.items():
            misses.setdefault(name, []).append(np.sqrt(column))
    return {name: size(np.concatenate(parts)) for name, parts in misses.items()}
