"""Floor slope: creep towards one direction of the floor.

On a tilted floor tyres creep downhill, sideways or lengthwise, by a share of the way driven; on oil, wet
paint or any other film that gives way like one they do so all the time, also where they stand. Seen as a
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
        pace: speed of travel [m/s] at which a film lets it creep by `rate`, and as fast when it stands;
            0 where creep goes with the way.
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
