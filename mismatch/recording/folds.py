"""Folds for cross-validation: laps where they are known, else blocks of time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.mismatch.recording.signals import WINDOW

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.recording import Recording

Kind = Literal["laps", "blocks", "moments"]

SHORTEST = 8.0  # [s] shortest block that is held out
MAX_BLOCKS = 8  # folds of a recording without laps


def laps_of(recording: Recording) -> list[tuple[float, float]]:
    """Return the laps of a recording within its time, as (start, end) [s]; none where there are none."""
    if recording.run is None:
        return []
    first, last = float(recording.time[0]), float(recording.time[-1])
    laps = [(max(lap.start, first), min(lap.end, last)) for lap in recording.run.laps]
    return [(start, end) for start, end in laps if end > start]


def folds_of(windows: Sequence[Windows], kind: Kind = "laps") -> list[NDArray[np.int64]]:
    """Return for each recording the number of the fold of each window's end, `(M + 1,)`.

    "laps" are a fold for each lap and the time until the next, if all recordings have laps and together two
    or more, and else blocks of time of equal length; "blocks" every fourth of short blocks; "moments" every
    other pair of windows.
    """
    if kind != "laps":
        length, count = (SHORTEST, 4) if kind == "blocks" else (2.0 * WINDOW, 2)
        return [
            (np.floor((model.time - model.time[0]) / length) % count).astype(np.int64) for model in windows
        ]
    laps = [laps_of(model.signals.recording) for model in windows]
    has_laps = sum(map(len, laps)) >= 2 and all(laps)
    folds, first = [], 0
    for model, of_recording in zip(windows, laps, strict=True):
        if has_laps:
            edges = np.array([start for start, _ in of_recording[1:]])
        else:
            span = float(model.time[-1] - model.time[0])
            count = int(np.clip(span / SHORTEST, 1, MAX_BLOCKS))
            edges = np.linspace(model.time[0], model.time[-1], count + 1)[1:-1]
        folds.append(first + np.searchsorted(edges, model.time, side="right").astype(np.int64))
        first += len(edges) + 1
    return folds
