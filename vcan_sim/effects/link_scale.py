"""Link scale: a scale error of the linear encoder.

A wrong counts_per_metre, or a rack that wears. It acts on the difference from the length at rest, so
that it is seen only while the slider moves. Source: a scale.
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
class LinkScale(Effect):
    """A scale error of the linear encoder.

    Attributes:
        ratio: read over true difference.
    """

    ratio: float = 1.0

    name: ClassVar[str] = "link_scale"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = LINK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.02, low=0.1, high=10.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Scale the difference from rest."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, block.rest + self.ratio * (reading - block.rest)), state
