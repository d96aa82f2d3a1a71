"""Wheelbase: the truck turns as if its wheels stood closer or wider.

Tyres touch the floor in an area, not at a point (U II). Seen in turns only; on squares driven one way it
is made up for by unequal wheels. Source: U (2.5), (4.4).
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
class Wheelbase(Effect):
    """Effective wheelbase times a ratio.

    Attributes:
        ratio: true over nominal wheelbase.
    """

    ratio: float = 1.0

    name: ClassVar[str] = "wheelbase"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.01, low=0.5, high=2.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Divide the yaw by the ratio."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        twist[:, 2] /= self.ratio
        return block.with_twist(truck, twist), state
