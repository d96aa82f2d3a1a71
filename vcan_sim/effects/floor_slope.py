"""Floor slope: creep towards one direction of the floor.

On a tilted floor tyres creep downhill, sideways or lengthwise, by a share of the way driven. Seen as a
displacement that turns with the heading; the linkage alone never shows it where both trucks creep alike.
Source: creep in proportion to the force along the slope.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vcan_sim.effects.block import truck_number
from vcan_sim.effects.effect import TRUCK, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class FloorSlope(Effect):
    """Creep towards one direction of the floor.

    Attributes:
        rate: creep per metre travelled.
        direction: in the world, counter-clockwise from x [rad].
    """

    rate: float = 0.0
    direction: float = 0.0

    name: ClassVar[str] = "floor_slope"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("rate", "1", null=0.0, scale=0.005, low=0.0, high=1.0),
        Parameter("direction", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the creep, turned into the truck's own frame."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        creep = self.rate * np.abs(twist[:, 0])
        angle = self.direction - block.heading[:, truck]
        twist[:, 0] += creep * np.cos(angle)
        twist[:, 1] += creep * np.sin(angle)
        return block.with_twist(truck, twist), state
