"""Which stretch each window belongs to: laps where they are known, else blocks of time."""

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

SHORTEST = 8.0  # [s] of a block that is held out
_BLOCKS = 8  # into which a recording without laps is cut


def laps_of(recording: Recording) -> list[tuple[float, float]]:
    """Return the laps of a recording within its time, as (start, end) [s]; none where there are none."""
    if recording.run is None:
        return []
    first, last = float(recording.time[0]), float(recording.time[-1])
    laps = [(max(lap.start, first), min(lap.end, last)) for lap in recording.run.laps]
    return [(start, end) for start, end in laps if end > start]


def folds_of(windows: Sequence[Windows], kind: Kind = "laps") -> list[NDArray[np.int64]]:
    """Return of each recording the number (M + 1,) of the stretch that may be held out.

    Args:
        windows: of each recording.
        kind: "laps", if all recordings together have two or more, with what lies between them counted to
            the lap before, and else blocks of time of equal length; "blocks", every fourth of short
            blocks in one; "moments", every other window.
    """
    if kind != "laps":
        length = SHORTEST if kind == "blocks" else 2.0 * WINDOW
        count = 4 if kind == "blocks" else 2
        return [(np.floor((one.time - one.time[0]) / length) % count).astype(np.int64) for one in windows]
    laps = [laps_of(one.signals.recording) for one in windows]
    enough = sum(len(own) for own in laps) >= 2 and all(laps)
    folds, first = [], 0
    for one, own in zip(windows, laps, strict=True):
        if enough:
            edges = np.array([start for start, _ in own[1:]])
        else:
            span = float(one.time[-1] - one.time[0])
            count = int(np.clip(span / SHORTEST, 1, _BLOCKS))
            edges = np.linspace(one.time[0], one.time[-1], count + 1)[1:-1]
        number = np.searchsorted(edges, one.time, side="right")
        folds.append(first + number.astype(np.int64))
        first += len(edges) + 1
    return folds
