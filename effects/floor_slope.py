"""Floor slope: the truck creeps towards one direction of the floor.

On a tilted floor tyres creep downhill, sideways or lengthwise, by a part of the way driven. On oil, wet
paint or another film that yields, they creep all the time, and also while the truck stands.

It is seen as a displacement whose direction in the truck's frame turns with the heading. The linkage alone
does not show it where both trucks creep alike.

It is confused with lateral slip and with wheel misalignment where the heading hardly changes.

The source is creep in proportion to the force along the slope.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import truck_number
from omnimate.effects.effect import TRUCK, Effect, Parameter

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class FloorSlope(Effect):
    """The truck creeps towards one direction of the floor.

    Attributes:
        rate: Creep per metre travelled.
        direction: Direction of the creep in the world, counter-clockwise from x [rad].
        pace: Speed of travel at which a yielding film lets the truck creep by `rate`, and with the same
            speed while it stands [m/s]; 0 where the creep goes with the way driven.
    """

    rate: float = 0.0
    direction: float = 0.0
    pace: float = 0.0

    name: ClassVar[str] = "floor_slope"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("rate", "1", null=0.0, scale=0.005, low=0.0, high=1.0),
        Parameter("direction", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
        Parameter("pace", "m/s", null=None, scale=0.3, low=0.0, high=20.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the creep, turned into the truck's own frame."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        creep = self.rate * (self.pace * block.period if self.pace else np.abs(twist[:, 0]))
        angle = self.direction - block.heading[:, truck]
        twist[:, 0] += creep * np.cos(angle)
        twist[:, 1] += creep * np.sin(angle)
        return block.with_twist(truck, twist), state
