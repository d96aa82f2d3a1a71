"""Wheel diameter: the wheel rolls another circumference per turn than its owner believes.

Worn, loaded or never measured wheels (unequal diameters, U II). Seen as a heading error in proportion to
the way and as a length error; confused with the truck's other wheel, and on closed squares driven one
way with the wheelbase. Source: U (2.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from vcan_sim.effects.block import wheel_number
from vcan_sim.effects.effect import WHEEL, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class WheelDiameter(Effect):
    """Travel times a ratio.

    Attributes:
        ratio: true over nominal circumference.
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
