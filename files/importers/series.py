"""The common form of all sources: checked quantities over time, and absolute poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.vehicle.recording import Poses
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.se2 import Array


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


def check_times(time: Array, place: Callable[[int], str]) -> None:
    """Raise an error for times `(K,)` [s] that are not finite, lie before 0, or do not increase.

    `place` returns the place in the source of a row, counted from 0, for the message.

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


def poses_of(truck: TruckName, time: Array, pose: Array, sigma: Array | None = None) -> Poses:
    """Return the absolute poses of a truck; rows without a known component are left out.

    Times are `(M,)` [s], poses x, y [m] and theta [rad], not necessarily wrapped, and their standard
    deviations `(M, 3)`; nan where unknown.
    """
    known = np.isfinite(pose).any(axis=1)
    stated = np.full(pose.shape, np.nan) if sigma is None else sigma
    kept = pose[known].copy()
    kept[:, 2] = wrap(kept[:, 2])
    return Poses(time[known].copy(), np.full(int(known.sum()), truck, "U1"), kept, stated[known].copy())


def merge_poses(parts: Iterable[Poses]) -> Poses | None:
    """Return the poses of several trucks in order of time; None where there are none."""
    parts = [part for part in parts if len(part.time)]
    if not parts:
        return None
    time = np.concatenate([part.time for part in parts])
    order = np.argsort(time, kind="stable")
    body, pose, sigma = (
        np.concatenate([getattr(part, name) for part in parts])[order] for name in ("body", "pose", "sigma")
    )
    return Poses(time[order], body, pose, sigma)
