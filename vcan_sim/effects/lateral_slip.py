"""Lateral slip: sideways creep in proportion to lateral acceleration.

Tyres need a slip angle to carry the centripetal force: outward sideways speed = compliance v yaw rate.
Seen in fast arcs; confused with a slope of the floor where one direction is driven. Source: linear
cornering stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from vcan_sim.effects.block import truck_number
from vcan_sim.effects.effect import TRUCK, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class LateralSlip(Effect):
    """Outward sideways speed = compliance v yaw rate.

    Attributes:
        compliance: sideways speed per lateral acceleration [s].
    """

    compliance: float = 0.0

    name: ClassVar[str] = "lateral_slip"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("compliance", "s", null=0.0, scale=0.02, low=0.0, high=10.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Creep outwards: to the right in a turn to the left."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        twist[:, 1] -= self.compliance * twist[:, 0] * twist[:, 2] / block.period
        return block.with_twist(truck, twist), state
