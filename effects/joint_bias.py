"""Joint bias: a joint's encoder reads a constant angle too much.

Its zero was set by eye.

It is seen as a truck that seems to travel at an angle behind or before the other.

It is confused with a turned axle (wheel misalignment), unless headings are measured from outside.

The source is C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import JOINT, MISCALIBRATED, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage, Startup


@dataclass(frozen=True, slots=True)
class JointBias(Effect):
    """The reading is the joint's angle plus a constant.

    Attributes:
        bias: Angle that the joint reads too much [rad].
    """

    bias: float = 0.0

    name: ClassVar[str] = "joint_bias"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = JOINT
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("bias", "rad", null=0.0, scale=0.01, low=-3.2, high=3.2),
    )
    prior: ClassVar[Prior] = Prior(MISCALIBRATED, background=0.01, discrepancy=0.01)
    regime: ClassVar[str] = "always"
    separating_drive: ClassVar[str] = "a straight with the headings of both trucks measured from outside"
    says: ClassVar[str] = "{part} reads {bias:+.3f} degrees too much, all the time."
    startup_nuisance: ClassVar[Startup | None] = "always"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the bias."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, reading + self.bias), state
