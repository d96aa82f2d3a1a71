"""Castor kick: the truck yaws each time its direction of travel reverses.

Castors swing round when the truck reverses, and push it sideways. Single kicks scatter; this is their mean.

It is seen as a step of the heading at reversals only.

It is confused with backlash in the gears of the wheels.

The source is U III-C: castors as a cause of non-systematic errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.vcan_sim.effects.block import truck_number
from omnimate.vcan_sim.effects.effect import TRUCK, Effect, Parameter
from omnimate.vcan_sim.effects.play import follow

SWING = 1e-3  # [m] that a truck has to go back before castors feel it: noise of counts is no reversal

if TYPE_CHECKING:
    from omnimate.vcan_sim.effects.block import Block
    from omnimate.vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class CastorKick(Effect):
    """The truck yaws at every reversal of its travel.

    Attributes:
        yaw: Yaw at each reversal [rad].
    """

    yaw: float = 0.0

    name: ClassVar[str] = "castor_kick"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("yaw", "rad", null=0.0, scale=0.003, low=-1.0, high=1.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Yaw in the first step after each reversal; remember the way and how far it is followed."""
        truck = truck_number(self.component)
        start, followed, last = (0.0, 0.0, 0.0) if state is None else state
        way = start + np.cumsum(block.twist[:, truck, 0])
        steady = follow(way, followed, 2.0 * SWING)
        moved = np.sign(np.diff(np.concatenate(([followed], steady))))
        known = np.concatenate(([last], moved))
        before = known[np.maximum.accumulate(np.where(known != 0.0, np.arange(len(known)), 0))]
        reversed_ = (moved != 0.0) & (before[:-1] != 0.0) & (moved != before[:-1])
        twist = block.twist[:, truck].copy()
        twist[:, 2] += np.where(reversed_, self.yaw, 0.0)
        return block.with_twist(truck, twist), (float(way[-1]), float(steady[-1]), float(before[-1]))
