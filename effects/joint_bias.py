"""Joint bias: a joint's encoder reads a constant angle too much.

Its zero was set by eye.

It is seen as a truck that seems to travel at an angle behind or before the other.

It is confused with a turned axle (wheel misalignment), unless headings are measured from outside.

The source is C 5.1.
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import JOINT, MISCALIBRATED, Array, Block, ChannelEffect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class JointBias(ChannelEffect):
    """The reading is the joint's angle plus a constant."""

    bias: float = 0.0  # angle that the joint reads too much [rad]

    name = "joint_bias"
    components = JOINT
    parameters = (Parameter("bias", "rad", null=0.0, scale=0.01, low=-3.2, high=3.2),)
    prior = Prior(MISCALIBRATED, background=0.01, discrepancy=0.01)
    separating_drive = "a straight with the headings of both trucks measured from outside"
    says = "{part} reads {bias:+.3f} degrees too much, all the time."
    startup_nuisance = "always"

    def shown(self, block: Block, reading: Array) -> Array:  # noqa: ARG002
        """Return the reading and the bias."""
        return reading + self.bias
