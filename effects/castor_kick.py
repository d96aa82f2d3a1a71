"""Castor kick: the truck yaws each time its direction of travel reverses.

Castors swing round when the truck reverses, and push it sideways while they do. Single kicks scatter; this is
their mean. `swing` is the way over which they come; without it the truck yaws at once.

It is seen as a step of the heading at reversals only.

It is confused with backlash in the gears of the wheels.

The source is U III-C: castors as a cause of non-systematic errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.block import truck_number
from omnimate.effects.effect import FAULT, TRUCK, Effect, Parameter, Prior
from omnimate.effects.play import follow

SWING = 1e-3  # [m] that a truck has to go back before castors feel it: noise of counts is no reversal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.effects.block import Block
    from omnimate.effects.effect import Drive
    from omnimate.vehicle.se2 import Array

SWINGS = (0.0, 0.05, 0.15)  # [m] over which castors swing round: a few of their own trails


@dataclass(frozen=True, slots=True)
class CastorKick(Effect):
    """The truck yaws at every reversal of its travel.

    Attributes:
        yaw: Yaw at each reversal [rad].
        swing: Way after a reversal over which the castors swing round, and the truck yaws [m]; 0 where it
            yaws at once.
    """

    yaw: float = 0.0
    swing: float = 0.0

    name = "castor_kick"
    stage = "body"
    components = TRUCK
    parameters = (
        Parameter("yaw", "rad", null=0.0, scale=0.003, low=-1.0, high=1.0),
        Parameter("swing", "m", null=None, scale=0.05, low=0.0, high=1.0),
    )
    prior = Prior(FAULT, background=0.1, discrepancy=0.3)
    regime = "at reversals of travel"
    separating_drive = "ten reversals on one straight"
    says = "{part} yaws by {yaw:+.3f} degrees each time it reverses: its castors swing round."

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Yaw after each reversal; remember the way, how far it is followed, and how long ago it turned."""
        truck = truck_number(self.component)
        start, followed, last, since = (0.0, 0.0, 0.0, np.inf) if state is None else state
        way = start + np.cumsum(block.twist[:, truck, 0])
        steady = follow(way, followed, 2.0 * SWING)
        moved = np.sign(np.diff(np.concatenate(([followed], steady))))
        known = np.concatenate(([last], moved))
        before = known[np.maximum.accumulate(np.where(known != 0.0, np.arange(len(known)), 0))]
        reversed_ = (moved != 0.0) & (before[:-1] != 0.0) & (moved != before[:-1])
        twist = block.twist[:, truck].copy()
        swung, since = self._swung(reversed_, np.abs(block.twist[:, truck, 0]), since)
        twist[:, 2] += self.yaw * swung
        return block.with_twist(truck, twist), (float(way[-1]), float(steady[-1]), float(before[-1]), since)

    def _swung(self, reversed_: NDArray[np.bool_], gone: Array, since: float) -> tuple[Array, float]:
        """Return which part of the yaw comes in each step, and the way since the last reversal [m].

        Args:
            reversed_: Whether the truck reverses in each step, shape `(K,)`.
            gone: Way of each step, shape `(K,)` [m].
            since: Way since the last reversal before the first step [m].
        """
        if self.swing == 0.0:
            return reversed_.astype(np.float64), since
        total = np.cumsum(gone)
        at = np.maximum.accumulate(np.where(reversed_, np.arange(len(gone)), -1))
        turned = np.where(at >= 0, total[at] - gone[at], -since)  # way counted when it reversed last
        after = np.minimum(total - turned, self.swing)
        before = np.minimum(total - gone - turned, self.swing)
        return (after - before) / self.swing, float(total[-1] - turned[-1])

    @classmethod
    def grid(cls, drive: Drive) -> Sequence[dict[str, float]]:  # noqa: ARG003
        """Return distances over which castors swing round."""
        return [{"swing": swing} for swing in SWINGS]
