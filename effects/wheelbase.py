"""Wheelbase: the truck turns as if its wheels stood closer together or further apart.

Tyres touch the floor in an area and not in a point, so that the effective wheelbase is uncertain (U II).

It is seen in turns only.

It is confused with unequal wheel diameters on squares that are driven one way only, because these
compensate it there.

The source is U (2.5) and (4.4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import truck_number
from omnimate.effects.effect import TRUCK, Effect, Parameter

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class Wheelbase(Effect):
    """The effective wheelbase is the nominal one, multiplied by a ratio.

    Attributes:
        ratio: True wheelbase, divided by the nominal one.
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
