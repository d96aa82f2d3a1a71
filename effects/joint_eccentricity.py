"""Joint eccentricity: a joint's encoder has an error that repeats once per turn.

The disc of the encoder is mounted off its centre. The reading is angle + amplitude cos(angle + phase).

It is seen as a bias that changes with the joint's angle.

It is confused with a constant bias where the joint hardly moves.

The source is the eccentricity of graduated circles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, JOINT, PHASE, Array, Block, ChannelEffect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class JointEccentricity(ChannelEffect):
    """The reading is angle + amplitude cos(angle + phase)."""

    amplitude: float = 0.0  # largest error of the reading [rad]
    phase: float = 0.0  # phase of the error at angle 0 [rad]

    name = "joint_eccentricity"
    components = JOINT
    parameters = (Parameter("amplitude", "rad", null=0.0, scale=0.005, low=0.0, high=1.0), PHASE)
    prior = Prior(FAULT, largest=6.0)
    regime = "angle of {component}"
    separating_drive = "car-like turns that take the joint through a wide range of angles"
    says = (
        "{part} errs by {amplitude:.3f} degrees once per turn of the joint: its disc is mounted off centre."
    )
    plotted_over = "joint angle"

    def shown(self, block: Block, reading: Array) -> Array:  # noqa: ARG002
        """Return the reading and its error."""
        return reading + self.amplitude * np.cos(reading + self.phase)
