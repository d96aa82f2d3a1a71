"""Link scale: the linear encoder has a scale error.

`counts_per_metre` is wrong, or the rack wears. The error acts on the difference from the length at rest.

It is seen only while the slider moves.

It is confused with a bias of the link where the slider stands at nearly the same place all the time.

The source is a wrong scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import LINK, RARE, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class LinkScale(Effect):
    """The difference from the length at rest is multiplied by a ratio.

    Attributes:
        ratio: Difference from the length at rest as it is read, divided by the true one.
    """

    ratio: float = 1.0

    name: ClassVar[str] = "link_scale"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = LINK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.02, low=0.1, high=10.0),
    )
    prior: ClassVar[Prior] = Prior(RARE)
    regime: ClassVar[str] = "link length"
    separating_drive: ClassVar[str] = "a drive that moves the slider over its stroke"
    says: ClassVar[str] = "{part} has a scale that is wrong by {ratio_percent:+.3f} %."
    plotted_over: ClassVar[Abscissa] = "link length"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Scale the difference from rest."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, block.rest + self.ratio * (reading - block.rest)), state
