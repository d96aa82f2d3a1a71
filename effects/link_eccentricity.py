"""Link eccentricity: the error of the link's length depends on a joint's angle.

The link is not hinged at the axis of the joint. The reading is length + amplitude cos(angle of joint_a +
phase).

It is seen in turns with the joints at large angles, as a car drives them.

It is confused with an eccentric encoder of the joint.

The source is the geometry of an offset hinge, to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import LINK, PHASE, RARE, Array, Block, ChannelEffect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class LinkEccentricity(ChannelEffect):
    """The reading is length + amplitude cos(angle of joint_a + phase)."""

    amplitude: float = 0.0  # largest error of the reading [m]
    phase: float = 0.0  # phase of the error at angle 0 of joint_a [rad]

    name = "link_eccentricity"
    components = LINK
    parameters = (Parameter("amplitude", "m", null=0.0, scale=0.002, low=0.0, high=1.0), PHASE)
    prior = Prior(RARE, largest=5.0)
    regime = "angle of joint_a"
    separating_drive = "car-like turns that take joint_a through a wide range of angles"
    says = "{part} errs by {amplitude:.2f} mm with the angle of joint a."
    plotted_over = "joint angle"

    def shown(self, block: Block, reading: Array) -> Array:
        """Return the reading and its error."""
        return reading + self.amplitude * np.cos(block.reading[:, 0] + self.phase)
