"""In which blocks of time, and on which signals, a candidate takes something of the mismatch away."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.answer.where import channels_of, laps_at, places_at
from omnimate.mismatch.diagnosis import Where
from omnimate.mismatch.recording.folds import SHORTEST

if TYPE_CHECKING:
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.vehicle.se2 import Array

Interval = tuple[float, float]

HALF = 0.5  # of what a candidate takes away, which the blocks that are named hold
EVERYWHERE = 0.25  # of all blocks, from which on it acts all along the drive


def where(regression: Regression, before: Array, part: Array) -> Where:
    """Return where a part of what is left of the data is seen.

    Args:
        regression: Of the recordings.
        before: What is left of the data without a candidate, whitened, `(V,)`.
        part: What the candidate takes of it, `(V,)`.
    """
    intervals = _intervals(regression, before**2 - (before - part) ** 2)
    signals = [windows.signals for windows in regression.windows]
    return Where(
        channels_of(regression, part),
        intervals,
        "" if intervals else "all along the drive",
        laps_at(intervals, signals),
        places_at(intervals, signals),
    )


def _intervals(regression: Regression, taken: Array) -> tuple[Interval, ...]:
    """Return the fewest blocks that hold half of what is taken away; none where these are many."""
    blocks: list[tuple[int, Interval]] = []
    power: list[float] = []
    time = regression.time
    for number, windows in enumerate(regression.windows):
        start, end = float(windows.time[0]), float(windows.time[-1])
        edges = np.linspace(start, end, max(1, round((end - start) / SHORTEST)) + 1)
        mine = regression.owner == number
        at = np.clip(np.searchsorted(edges, time[mine], side="right") - 1, 0, len(edges) - 2)
        power += np.bincount(at, weights=taken[mine], minlength=len(edges) - 1).tolist()
        blocks += [(number, (a, b)) for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]
    order = np.argsort(power)[::-1]
    held = np.cumsum(np.asarray(power)[order])
    count = int(np.searchsorted(held, HALF * sum(power))) + 1
    if count > EVERYWHERE * len(blocks):
        return ()
    return _joined([blocks[at] for at in sorted(order[:count].tolist())])


def _joined(blocks: list[tuple[int, Interval]]) -> tuple[Interval, ...]:
    """Return blocks in order of time, those that follow each other in one recording as one."""
    found: list[tuple[int, Interval]] = []
    for owner, (start, end) in blocks:
        if found and found[-1][0] == owner and found[-1][1][1] == start:
            found[-1] = owner, (found[-1][1][0], end)
        else:
            found.append((owner, (start, end)))
    return tuple(interval for _, interval in found)
