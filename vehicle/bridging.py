"""The travel that a restarted wheel counter has lost, estimated from the truck's other wheel.

A counter that begins anew says nothing of the way driven meanwhile; the other wheel of the truck was read
on. Until the gap the two turned in some proportion, on a straight line or on the spot, and the missing
travel is taken in the same proportion. The same law is used live and offline.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.counters import Counter
    from omnimate.vehicle.parameters import Channel, VehicleParameters

WINDOW = 10  # samples before the gap, over which the proportion is taken
MAX_RATIO = 4.0  # of the wheels' travels; beyond it the other wheel hardly moves and says nothing

_PARTNERS: dict[Channel, Channel] = {
    "a.left": "a.right",
    "a.right": "a.left",
    "b.left": "b.right",
    "b.right": "b.left",
}


def partners(vehicle: VehicleParameters) -> dict[int, int]:
    """Return for the column of each wheel the column of the other wheel of its truck."""
    columns = {channel: column for column, channel in enumerate(vehicle.channels)}
    return {columns[wheel]: columns[_PARTNERS[wheel]] for wheel in vehicle.wheels}


def lost_counts(wheel: int, partner: int, partner_since: int, scale: float, partner_scale: float) -> int:
    """Return the counts that a restarted wheel has most likely lost.

    Args:
        wheel: Counts of the wheel over the window before the gap.
        partner: Counts of the truck's other wheel over the same window.
        partner_since: Counts of the other wheel over the gap.
        scale: Metres per count of the wheel [m].
        partner_scale: Metres per count of the other wheel [m].
    """
    if partner == 0 or abs(wheel * scale) > MAX_RATIO * abs(partner * partner_scale):
        return 0
    return round(partner_since * wheel / partner)


class _Wheel:
    """One wheel and the other one of its truck, over the last samples."""

    def __init__(self, vehicle: VehicleParameters, wheel: int, other: int) -> None:
        self.column, self.other = wheel, other
        self._scale = vehicle.metres_per_count(vehicle.channels[wheel])
        self._other_scale = vehicle.metres_per_count(vehicle.channels[other])
        self._rows: deque[tuple[int, int]] = deque(maxlen=WINDOW + 1)
        self._since: deque[tuple[int, int]] = deque(maxlen=WINDOW)
        self._other_restarted = False

    def lost(self, counter: Counter, other: Counter) -> int:
        """Return what the wheel has lost, if its counter began anew in this sample."""
        self._other_restarted |= other.rebased
        if not counter.rebased or other.count is None or not self._rows or self._other_restarted:
            return 0
        first, last = self._rows[0], self._rows[-1]
        return lost_counts(
            last[0] - first[0], last[1] - first[1], other.count - last[1], self._scale, self._other_scale
        )

    def keep(self, counter: Counter, other: Counter, *, both: bool) -> None:
        """Keep where both stand; `both` if both were read in this sample."""
        if counter.count is None or other.count is None:
            return
        self._since.append((counter.count, other.count))
        if both:
            self._rows.extend(self._since)
            self._since.clear()
            self._other_restarted = False


class Bridges:
    """All wheels of a vehicle, followed sample by sample; `bridge` does the same for a recording."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._wheels = [_Wheel(vehicle, column, other) for column, other in partners(vehicle).items()]

    def follow(self, counters: Sequence[Counter], present: Sequence[bool]) -> None:
        """Take one sample after all of its readings; correct the counters that began anew in it."""
        lost = [wheel.lost(counters[wheel.column], counters[wheel.other]) for wheel in self._wheels]
        for wheel, missing in zip(self._wheels, lost, strict=True):
            if missing:
                counters[wheel.column].correct(missing)
        for wheel in self._wheels:
            both = present[wheel.column] and present[wheel.other]
            wheel.keep(counters[wheel.column], counters[wheel.other], both=both)


def bridge(
    vehicle: VehicleParameters,
    counts: NDArray[np.int64],
    present: NDArray[np.bool_],
    rebased: NDArray[np.bool_],
) -> None:
    """Add to the counts `(N, C)` of restarted wheels, in place, what they have most likely lost.

    Args:
        vehicle: Robot whose channels the columns of the arrays are.
        counts: Unwrapped counts.
        present: Readings that were believed, shape `(N, C)`.
        rebased: Readings at which a counter had begun anew, shape `(N, C)`.
    """
    others = partners(vehicle)
    both = {wheel: present[:, wheel] & present[:, other] for wheel, other in others.items()}
    for row in np.flatnonzero(rebased.any(axis=1)).tolist():
        lost = {}
        for wheel in np.flatnonzero(rebased[row]).tolist():
            other = others[wheel]
            before = np.flatnonzero(both[wheel][:row])
            if len(before) == 0:
                continue
            last = int(before[-1])
            if rebased[last + 1 : row + 1, other].any():
                continue
            first = max(last - WINDOW, 0)
            lost[wheel] = lost_counts(
                int(counts[last, wheel] - counts[first, wheel]),
                int(counts[last, other] - counts[first, other]),
                int(counts[row, other] - counts[last, other]),
                vehicle.metres_per_count(vehicle.channels[wheel]),
                vehicle.metres_per_count(vehicle.channels[other]),
            )
        for wheel, missing in lost.items():
            counts[row:, wheel] += missing
