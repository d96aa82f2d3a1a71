"""Wheel misalignment: the truck travels at a small angle to its frame's straight ahead.

The axle is turned in the frame, to which joint angles and headings refer. The truck travels along the
normal of the axle.

It is seen as a sideways way in proportion to the travel forward.

It is confused with the bias of a joint's encoder: the linkage alone cannot tell the two apart.

The source is the geometry of an axle that is turned in its frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, Array, Block, Parameter, Prior, TruckEffect


@dataclass(frozen=True, slots=True)
class WheelMisalignment(TruckEffect):
    """The truck travels at an angle to its frame's straight ahead."""

    angle: float = 0.0  # angle of the axle in the frame, counter-clockwise [rad]

    name = "wheel_misalignment"
    parameters = (Parameter("angle", "rad", null=0.0, scale=0.01, low=-1.0, high=1.0),)
    prior = Prior(FAULT, background=0.01)
    regime = "in proportion to the way driven"
    separating_drive = "a straight with absolute headings and positions of the truck measured"
    says = (
        "the axle of {part} is turned by {angle:+.3f} degrees: "
        "it travels at that angle to its own straight ahead."
    )
    startup_nuisance = "always"

    def change(self, twist: Array, block: Block, truck: int) -> None:  # noqa: ARG002
        """Rotate the travel to the direction of the axle's normal."""
        forward = twist[:, 0].copy()
        twist[:, 0] = forward * np.cos(self.angle)
        twist[:, 1] += forward * np.sin(self.angle)
