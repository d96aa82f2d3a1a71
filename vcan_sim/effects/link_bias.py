"""Link bias: a constant offset of the link's length.

The linear encoder's zero was measured by tape. Seen where the joints stand at large angles; hidden while
the trucks drive in line. Source: C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from vcan_sim.effects.block import LINKAGE
from vcan_sim.effects.effect import LINK, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class LinkBias(Effect):
    """A constant offset of the link.

    Attributes:
        bias: [m].
    """

    bias: float = 0.0

    name: ClassVar[str] = "link_bias"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = LINK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("bias", "m", null=0.0, scale=0.005, low=-10.0, high=10.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the bias."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, reading + self.bias), state
