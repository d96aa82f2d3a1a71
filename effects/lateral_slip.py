"""Lateral slip: the truck creeps sideways in proportion to its lateral acceleration.

Tyres need a slip angle to carry the centripetal force. The sideways speed, outwards, is compliance v yaw
rate.

It is seen in fast arcs.

It is confused with a slope of the floor where arcs are driven in one direction only.

The source is a tyre of linear cornering stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import truck_number
from omnimate.effects.effect import RARE, TRUCK, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class LateralSlip(Effect):
    """The sideways speed, outwards, is compliance v yaw rate.

    Attributes:
        compliance: Sideways speed per lateral acceleration [s].
    """

    compliance: float = 0.0

    name: ClassVar[str] = "lateral_slip"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("compliance", "s", null=0.0, scale=0.02, low=0.0, high=10.0),
    )
    prior: ClassVar[Prior] = Prior(RARE, discrepancy=0.2)
    regime: ClassVar[str] = "turning, by speed times yaw rate"
    separating_drive: ClassVar[str] = "the same arc at two speeds"
    says: ClassVar[str] = "{part} creeps outwards in turns (compliance {compliance:.4g} s)."
    plotted_over: ClassVar[Abscissa] = "speed"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Creep outwards: to the right in a turn to the left."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        twist[:, 1] -= self.compliance * twist[:, 0] * twist[:, 2] / block.period
        return block.with_twist(truck, twist), state
