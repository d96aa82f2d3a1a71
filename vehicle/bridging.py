"""The travel that a restarted wheel counter has lost, estimated from the truck's other wheel.

A counter that begins anew says nothing of the way driven meanwhile; the other wheel of the truck was read
on. Until the gap the two turned in some proportion, on a straight line or on the spot, and the missing
travel is taken in the same proportion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.vehicle.compiled import IntArray, Record, compiled
from omnimate.vehicle.counters import Counter

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel, VehicleParameters

WINDOW = 10  # samples before the gap, over which the proportion is taken
MAX_RATIO = 4.0  # of the wheels' travels; beyond it the other wheel hardly moves and says nothing

_PARTNERS: dict[Channel, Channel] = {
    "a.left": "a.right",
    "a.right": "a.left",
    "b.left": "b.right",
    "b.right": "b.left",
}


class BridgedCounter(Counter):
    """Record of a counter that may be a wheel's.

    Attributes:
        partner: Column of the truck's other wheel; -1 where the counter is no wheel's.
        scale: Travel per count [m].
        history: Counts of the last samples, the sample of number n at n modulo its length.
        has_history: Whether the wheel has been read.
        lost: Counts that are added in this sample for what a restart has lost.
        is_pair_known: Whether both wheels were read in a sample; the last such one gives the next fields.
        pair_count: Count of the other wheel in it.
        pair_travel: Counts of both wheels over the `WINDOW` before it, this one's first, shape `(2,)`.
        is_partner_rebased: Whether the other wheel's counter has begun anew since then.
    """

    partner: int
    scale: float
    history: Annotated[IntArray, WINDOW + 1]
    has_history: bool
    lost: int
    is_pair_known: bool
    pair_count: int
    pair_travel: Annotated[IntArray, 2]
    is_partner_rebased: bool


def partners(vehicle: VehicleParameters) -> dict[int, int]:
    """Return for the column of each wheel the column of the other wheel of its truck."""
    columns = {channel: column for column, channel in enumerate(vehicle.channels)}
    return {columns[wheel]: columns[_PARTNERS[wheel]] for wheel in vehicle.wheels}


def set_partners(counters: Record, vehicle: VehicleParameters) -> None:
    """Write into counters `(C,)` which of them are wheels, and of which trucks."""
    counters["partner"] = -1
    for wheel, other in partners(vehicle).items():
        counters[wheel]["partner"] = other
        counters[wheel]["scale"] = vehicle.metres_per_count(vehicle.channels[wheel])


@compiled
def lost_counts(wheel: BridgedCounter, other: BridgedCounter) -> int:
    """Return the counts that a wheel has most likely lost, whose counter has begun anew in this sample."""
    travel, other_travel = float(wheel.pair_travel[0]), float(wheel.pair_travel[1])
    if not wheel.is_pair_known or wheel.is_partner_rebased or other_travel == 0.0:
        return 0
    if abs(travel * wheel.scale) > MAX_RATIO * abs(other_travel * other.scale):
        return 0
    return int(np.rint(float(other.count - wheel.pair_count) * travel / other_travel))


@compiled
def bridge(counters: Record, number: int) -> None:
    """Correct the counters `(C,)` that have begun anew in sample `number`, after all of its readings."""
    for column in range(len(counters)):
        wheel = counters[column]
        wheel.lost = 0
        if wheel.partner >= 0:
            wheel.is_partner_rebased |= counters[wheel.partner].rebased
            if wheel.rebased:
                wheel.lost = lost_counts(wheel, counters[wheel.partner])
    for column in range(len(counters)):
        wheel = counters[column]
        wheel.count += wheel.lost
        if wheel.partner >= 0:
            if wheel.is_known and not wheel.has_history:
                wheel.history[:] = wheel.count
                wheel.has_history = True
            wheel.history[number % len(wheel.history)] = wheel.count
    for column in range(len(counters)):
        wheel = counters[column]
        if wheel.partner >= 0 and wheel.present and counters[wheel.partner].present:
            _keep_pair(wheel, counters[wheel.partner], number)


@compiled
def _keep_pair(wheel: BridgedCounter, other: BridgedCounter, number: int) -> None:
    first = (number + 1) % len(wheel.history)
    wheel.pair_travel[0] = wheel.count - wheel.history[first]
    wheel.pair_travel[1] = other.count - other.history[first]
    wheel.pair_count = other.count
    wheel.is_pair_known, wheel.is_partner_rebased = True, False
