"""Wheel misalignment: the truck travels at a small angle to its frame's straight ahead.

The axle is turned in the frame, to which joint angles and headings refer. The truck travels along the
normal of the axle.

It is seen as a sideways way in proportion to the way forward.

It is confused with the bias of a joint's encoder: the linkage alone cannot tell the two apart.

The source is the geometry of an axle that is turned in its frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import truck_number
from omnimate.effects.effect import FAULT, TRUCK, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage, Startup


@dataclass(frozen=True, slots=True)
class WheelMisalignment(Effect):
    """The truck travels at an angle to its frame's straight ahead.

    Attributes:
        angle: Angle of the axle in the frame, counter-clockwise [rad].
    """

    angle: float = 0.0

    name: ClassVar[str] = "wheel_misalignment"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("angle", "rad", null=0.0, scale=0.01, low=-1.0, high=1.0),
    )
    prior: ClassVar[Prior] = Prior(FAULT, background=0.01)
    regime: ClassVar[str] = "in proportion to the way driven"
    separating_drive: ClassVar[str] = "a straight with absolute headings and positions of the truck measured"
    says: ClassVar[str] = (
        "the axle of {part} is turned by {angle:+.3f} degrees: "
        "it travels at that angle to its own straight ahead."
    )
    startup_nuisance: ClassVar[Startup | None] = "always"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Turn the way into the direction of the axle's normal."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        forward = twist[:, 0].copy()
        twist[:, 0] = forward * np.cos(self.angle)
        twist[:, 1] += forward * np.sin(self.angle)
        return block.with_twist(truck, twist), state
