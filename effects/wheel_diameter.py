"""Wheel diameter: a wheel rolls another way per turn than its owner believes.

Wheels wear, are pressed flat by the load, or were never measured; the two wheels of a truck then differ.

It is seen as a heading error in proportion to the way driven, and as an error of all lengths.

It is confused with the diameter of the truck's other wheel. On closed squares that are driven one way only,
it is also confused with the wheelbase.

The source is U (2.3): unequal wheel diameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import WHEEL, Effect, Parameter

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class WheelDiameter(Effect):
    """The wheel's travel is multiplied by a ratio.

    Attributes:
        ratio: True circumference of the wheel, divided by the nominal one.
    """

    ratio: float = 1.0

    name: ClassVar[str] = "wheel_diameter"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.01, low=0.5, high=2.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Scale the wheel's travel."""
        wheel = wheel_number(self.component)
        return block.with_travel(wheel, self.ratio * block.travel[:, wheel]), state
