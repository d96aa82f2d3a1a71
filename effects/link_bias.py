"""Link bias: the link's encoder reads a constant length too much.

The zero of the linear encoder was measured by tape.

It is seen where the joints stand at large angles, and is hidden while the trucks drive in line.

It is confused with an eccentric or wrongly scaled link where the slider hardly moves.

The source is C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import FAULT, LINK, Array, Block, ChannelEffect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class LinkBias(ChannelEffect):
    """The reading is the link's length plus a constant."""

    bias: float = 0.0  # length that the link reads too much [m]

    name = "link_bias"
    components = LINK
    parameters = (Parameter("bias", "m", null=0.0, scale=0.005, low=-10.0, high=10.0),)
    prior = Prior(FAULT, discrepancy=0.01)
    separating_drive = "car-like turns in both directions with the joints at large angles"
    says = "{part} reads {bias:+.2f} mm too much, all the time."

    def shown(self, block: Block, reading: Array) -> Array:  # noqa: ARG002
        """Return the reading and the bias."""
        return reading + self.bias
