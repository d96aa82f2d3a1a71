"""Link scale: the linear encoder has a scale error.

`counts_per_metre` is wrong, or the rack wears. The error acts on the difference from the length at rest.

It is seen only while the slider moves.

It is confused with a bias of the link where the slider stands at nearly the same place all the time.

The source is a wrong scale.
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import LINK, RARE, Array, Block, ChannelEffect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class LinkScale(ChannelEffect):
    """The difference from the length at rest is multiplied by a ratio."""

    ratio: float = 1.0  # difference from the length at rest as it is read, divided by the true one

    name = "link_scale"
    components = LINK
    parameters = (Parameter("ratio", "1", null=1.0, scale=0.02, low=0.1, high=10.0),)
    prior = Prior(RARE)
    regime = "link length"
    separating_drive = "a drive that moves the slider over its stroke"
    says = "{part} has a scale that is wrong by {ratio_percent:+.3f} %."
    plotted_over = "link length"

    def shown(self, block: Block, reading: Array) -> Array:
        """Return the reading, its difference from rest scaled."""
        return block.rest + self.ratio * (reading - block.rest)
