"""Joint bias: a constant offset of a joint's encoder.

Its zero was set by eye. Seen as a truck that seems to crab behind or before the other; without measured
headings it cannot be told from a turned axle. Source: C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from vcan_sim.effects.block import LINKAGE
from vcan_sim.effects.effect import JOINT, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class JointBias(Effect):
    """A constant offset of a joint.

    Attributes:
        bias: [rad].
    """

    bias: float = 0.0

    name: ClassVar[str] = "joint_bias"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = JOINT
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("bias", "rad", null=0.0, scale=0.01, low=-3.2, high=3.2),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the bias."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, reading + self.bias), state
