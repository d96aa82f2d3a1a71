"""Link bias: the link's encoder reads a constant length too much.

The zero of the linear encoder was measured by tape.

It is seen where the joints stand at large angles, and is hidden while the trucks drive in line.

It is confused with an eccentric or wrongly scaled link where the slider hardly moves.

The source is C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import LINK, Effect, Parameter

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class LinkBias(Effect):
    """The reading is the link's length plus a constant.

    Attributes:
        bias: Length that the link reads too much [m].
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
