"""Blocks of time and signals in which a candidate explains the mismatch."""

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

EXPLAINED_FRACTION = 0.5  # of what a candidate explains that the reported blocks contain
MAX_BLOCK_FRACTION = 0.25  # of all blocks; in more, it acts all along the drive


def where(regression: Regression, before: Array, part: Array) -> Where:
    """Return where and when a candidate explains the residual.

    Args:
        regression: Regression of the recordings.
        before: Whitened residual of the data without the candidate, `(V,)`.
        part: Part of it that the candidate explains, `(V,)`.
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


def _intervals(regression: Regression, by_row: Array) -> tuple[Interval, ...]:
    """Return the fewest blocks with half of the decrease of chi-square (V,); none where they are many."""
    blocks: list[tuple[int, Interval]] = []
    decrease: list[float] = []
    time = regression.time
    for number, windows in enumerate(regression.windows):
        start, end = float(windows.time[0]), float(windows.time[-1])
        edges = np.linspace(start, end, max(1, round((end - start) / SHORTEST)) + 1)
        rows = regression.rows_of(number)
        block = np.clip(np.searchsorted(edges, time[rows], side="right") - 1, 0, len(edges) - 2)
        decrease += np.bincount(block, weights=by_row[rows], minlength=len(edges) - 1).tolist()
        blocks += [(number, (a, b)) for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)]
    order = np.argsort(decrease)[::-1]
    total = np.cumsum(np.asarray(decrease)[order])
    count = int(np.searchsorted(total, EXPLAINED_FRACTION * sum(decrease))) + 1
    if count > MAX_BLOCK_FRACTION * len(blocks):
        return ()
    return _joined([blocks[at] for at in sorted(order[:count].tolist())])


def _joined(blocks: list[tuple[int, Interval]]) -> tuple[Interval, ...]:
    """Return blocks in order of time, adjacent ones of one recording as one interval."""
    joined: list[tuple[int, Interval]] = []
    for owner, (start, end) in blocks:
        if joined and joined[-1][0] == owner and joined[-1][1][1] == start:
            joined[-1] = owner, (joined[-1][1][0], end)
        else:
            joined.append((owner, (start, end)))
    return tuple(interval for _, interval in joined)
