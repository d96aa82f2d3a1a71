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
from omnimate.effects.effect import FAULT, LINK, Effect, Parameter, Prior

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
    prior: ClassVar[Prior] = Prior(FAULT, discrepancy=0.01)
    regime: ClassVar[str] = "always"
    separating_drive: ClassVar[str] = "car-like turns in both directions with the joints at large angles"
    says: ClassVar[str] = "{part} reads {bias:+.2f} mm too much, all the time."

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the bias."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, reading + self.bias), state
