"""Wheel eccentricity: the rolling radius varies once per turn of the wheel.

The tyre is out of round, or the bore of the axle is off its centre. The rolling radius is R + amplitude
cos(angle + phase), with the wheel's angle as it is counted from the encoder's zero.

It is seen as a wave in the heading and in the link's readings, once per turn of that wheel and zero on
average.

It is confused with a gear harmonic of order 1, whose wave has the same period.

The source is the geometry of an eccentric circle that rolls on a plane, to first order in amplitude / R.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, PHASE, Array, Block, Parameter, Prior, WheelEffect


@dataclass(frozen=True, slots=True)
class WheelEccentricity(WheelEffect):
    """The rolling radius is R + amplitude cos(angle + phase)."""

    amplitude: float = 0.0  # amplitude of the rolling radius [m]
    phase: float = 0.0  # phase of the wave at the encoder's zero [rad]

    name = "wheel_eccentricity"
    parameters = (Parameter("amplitude", "m", null=0.0, scale=3e-4, low=0.0, high=0.02), PHASE)
    prior = Prior(FAULT)
    regime = "wheel angle of {component}"
    separating_drive = "a slow straight of twenty wheel turns"
    says = "{part} runs out of round by {amplitude:.3f} mm: once per turn of that wheel the truck yaws."
    plotted_over = "wheel angle"
    startup_nuisance = "always"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the travel and the integral of the changed radius over the step."""
        end = block.angle[:, wheel]
        begin = end - block.turned[:, wheel]
        gained = self.amplitude * (np.sin(end + self.phase) - np.sin(begin + self.phase))
        return block.travel[:, wheel] + gained
