"""One checked quantity over time, the common form of all sources."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.importers.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.se2 import Array

Place = str  # place of a row in its source, for messages


@dataclass(frozen=True, slots=True)
class Series:
    """One quantity over time.

    Attributes:
        time: Time of each value [s], strictly increasing, shape `(K,)`.
        value: Values in the unit, shape `(K,)`; nan where not measured.
        unit: A unit of `omnimate.files.importers.units.UNITS`.
        source: Source for messages, such as `drive.csv, column left`.

    Raises:
        SourceError: There is no value, or the times do not increase.
    """

    time: Array
    value: Array
    unit: str
    source: str

    def __post_init__(self) -> None:
        if self.time.shape != self.value.shape:
            raise ValueError(f"{self.value.shape} values do not belong to {self.time.shape} times")
        check_times(self.time, lambda row: f"{self.source}, sample {row + 1}")
        if not np.isfinite(self.value).any():
            raise SourceError(self.source, "no value in it")


def check_times(time: Array, place: Callable[[int], Place]) -> None:
    """Refuse times `(K,)` [s] that are not finite, lie before 0, or do not increase.

    Args:
        time: Times to check [s], shape `(K,)`.
        place: Function that returns the place of a row, counted from 0, for the message.

    Raises:
        SourceError: A time is wrong; the message names its row.
    """
    bad = np.flatnonzero(~np.isfinite(time) | (time < 0.0))
    if len(bad):
        raise SourceError(
            place(int(bad[0])), f"time {time[bad[0]]} s; expected a finite time of 0 s or later"
        )
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        verb = "stands still" if time[row] == time[row - 1] else "goes backwards"
        raise SourceError(
            place(row),
            f"time {verb}, from {time[row - 1]:.6f} s to {time[row]:.6f} s; expected rows in order of time, "
            "one clock for all",
        )
