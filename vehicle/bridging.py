"""Estimation of the travel that a wheel counter lost in a gap, from the truck's other wheel.

During a restart, or while a counter passes its range unread, only the other wheel is counted. The ratio of
both wheels' travel before the gap, such as on a straight line or in a turn on the spot, is assumed to hold
during the gap.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.vehicle.compiled import IntArray, Record, compiled
from omnimate.vehicle.counters import Counter

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel, VehicleParameters

RATIO_WINDOW = 10  # samples before the gap over which the ratio is calculated (assumption)
MAX_RATIO = 4.0  # largest ratio of the wheels' travel; above it the other wheel hardly moves (assumption)

_PARTNERS: dict[Channel, Channel] = {
    "a.left": "a.right",
    "a.right": "a.left",
    "b.left": "b.right",
    "b.right": "b.left",
}


class BridgedCounter(Counter):
    """Record of a counter that may be a wheel's."""

    partner: int  # column of the truck's other wheel; -1 where the counter is no wheel's
    scale: float  # travel per count [m]
    history: Annotated[IntArray, RATIO_WINDOW + 1]  # last counts, of sample n at n modulo its length
    has_history: bool  # whether the wheel has been read
    is_pair_known: bool  # whether both wheels were read in some sample; of the last one are the next fields
    pair_counts: Annotated[IntArray, 2]  # counts of this and the other wheel in it
    pair_travel: Annotated[IntArray, 2]  # counts of this and the other over `RATIO_WINDOW`
    is_partner_rebased: bool  # whether the other wheel's counter was restarted since then


def partners(vehicle: VehicleParameters) -> dict[int, int]:
    """Return for the column of each wheel the column of the other wheel of its truck."""
    columns = {channel: column for column, channel in enumerate(vehicle.channels)}
    return {columns[wheel]: columns[_PARTNERS[wheel]] for wheel in vehicle.wheels}


def set_partners(counters: Record, vehicle: VehicleParameters) -> None:
    """Fill `partner` and `scale` of the counters `(C,)` that are wheels."""
    counters["partner"] = -1
    for wheel, other in partners(vehicle).items():
        counters[wheel]["partner"] = other
        counters[wheel]["scale"] = vehicle.metres_per_count(vehicle.channels[wheel])


@compiled
def lost_counts(wheel: BridgedCounter, other: BridgedCounter, unit: int) -> int:
    """Return the estimated counts that a wheel lost since both were read, a multiple of `unit`."""
    travel, other_travel = float(wheel.pair_travel[0]), float(wheel.pair_travel[1])
    if not wheel.is_pair_known or other_travel == 0.0:
        return 0
    if abs(travel * wheel.scale) > MAX_RATIO * abs(other_travel * other.scale):
        return 0
    counted = wheel.count - wheel.pair_counts[0]
    if counted != 0 and not other.present:  # what the other one has travelled meanwhile is unknown
        return 0
    lost = float(other.count - wheel.pair_counts[1]) * travel / other_travel - float(counted)
    return int(np.rint(lost / unit)) * unit


@compiled
def bridge(counters: Record, number: int) -> None:
    """Correct the counters `(C,)` that lost travel before sample `number`, after all of its readings.

    Of two ambiguous counters, the one that was not read for longer follows the other one.
    """
    for column in range(len(counters)):
        wheel = counters[column]
        if wheel.partner >= 0:
            other = counters[wheel.partner]
            wheel.is_partner_rebased |= other.rebased
            if wheel.present and other.present and wheel.ambiguous > other.ambiguous:
                wheel.count += lost_counts(wheel, other, wheel.periods[0])
    for column in range(len(counters)):
        wheel = counters[column]
        if wheel.rebased and not wheel.is_partner_rebased:
            wheel.count += lost_counts(wheel, counters[wheel.partner], 1)
        if wheel.partner >= 0:
            if wheel.is_known and not wheel.has_history:
                wheel.history[:] = wheel.count
                wheel.has_history = True
            wheel.history[number % len(wheel.history)] = wheel.count
    for column in range(len(counters)):
        wheel = counters[column]
        if wheel.partner >= 0 and wheel.present and counters[wheel.partner].present:
            _store_pair(wheel, counters[wheel.partner], number)


@compiled
def _store_pair(wheel: BridgedCounter, other: BridgedCounter, number: int) -> None:
    first = (number + 1) % len(wheel.history)
    wheel.pair_travel[0] = wheel.count - wheel.history[first]
    wheel.pair_travel[1] = other.count - other.history[first]
    wheel.pair_counts[0], wheel.pair_counts[1] = wheel.count, other.count
    wheel.is_pair_known, wheel.is_partner_rebased, wheel.ambiguous = True, False, 0
