"""The extended UMBmark: squares with and without bumps, judged by their return headings.

Sources: O 3, which takes the worst lap; Borenstein & Feng, UMBmark: a method for measuring, comparing, and
correcting dead-reckoning errors, UM-MEAM-94-22 (1994), which adds the averages of both directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class ExtendedResult:
    """Nonsystematic heading errors of an extended UMBmark."""

    systematic: Array  # mean return heading without bumps, cw and ccw [rad], `(2,)`
    excess_cw: Array  # |nonsystematic - mean systematic| heading of each cw lap with bumps [rad], `(n,)`
    excess_ccw: Array  # |nonsystematic - mean systematic| heading of each ccw lap with bumps [rad], `(m,)`

    @property
    def worst(self) -> float:
        """The largest excess of any lap [rad]: the result in O Table I."""
        return float(max(self.excess_cw.max(), self.excess_ccw.max()))

    @property
    def average(self) -> float:
        """The sum of the two directions' mean excess [rad]: the result in the report of 1994."""
        return float(self.excess_cw.mean() + self.excess_ccw.mean())


def extended_umbmark(
    smooth_cw: ArrayLike, smooth_ccw: ArrayLike, bumps_cw: ArrayLike, bumps_ccw: ArrayLike
) -> ExtendedResult:
    """Return the extended UMBmark of return headings `(n,)` [rad] without and with bumps.

    Raises:
        CalibrationError: One of the four is empty, or a heading is missing.
    """
    names = ("cw without bumps", "ccw without bumps", "cw with bumps", "ccw with bumps")
    headings = [np.asarray(laps, np.float64) for laps in (smooth_cw, smooth_ccw, bumps_cw, bumps_ccw)]
    for name, laps in zip(names, headings, strict=True):
        if laps.size == 0 or not np.isfinite(laps).all():
            raise CalibrationError("extended UMBmark", f"a return heading {name} is missing: measure theta")
    systematic = np.array([headings[0].mean(), headings[1].mean()])
    return ExtendedResult(
        systematic, np.abs(headings[2] - systematic[0]), np.abs(headings[3] - systematic[1])
    )
