"""Gear harmonic: an error that repeats several times per turn of the wheel.

It comes from teeth, from belts, or from the reader of an encoder. The travel is s + amplitude
cos(order angle + phase).

It is seen as a quick beat in the heading and in the link's readings.

It is confused with an eccentric wheel where the order is 1.

The source is the first harmonic of any periodic error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, PHASE, Array, Block, Parameter, Prior, WheelEffect


@dataclass(frozen=True, slots=True)
class GearHarmonic(WheelEffect):
    """The travel is s + amplitude cos(order angle + phase)."""

    amplitude: float = 0.0  # amplitude of the travel [m]
    order: float = 2.0  # number of beats per turn of the wheel
    phase: float = 0.0  # phase of the beat at the encoder's zero [rad]

    name = "gear_harmonic"
    parameters = (
        Parameter("amplitude", "m", null=0.0, scale=2e-4, low=0.0, high=0.02),
        Parameter("order", "1", null=None, scale=10.0, low=0.0, high=10000.0),
        PHASE,
    )
    prior = Prior(FAULT)
    regime = "wheel angle of {component}, order {order:g}"
    separating_drive = "a slow straight of twenty wheel turns"
    says = "{part} beats {order:g} times per turn, by {amplitude:.3f} mm: a gear or a belt."
    plotted_over = "wheel angle"
    scan = "order"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the travel and the change of the wave over the step."""
        end = self.order * block.angle[:, wheel] + self.phase
        begin = end - self.order * block.turned[:, wheel]
        return block.travel[:, wheel] + self.amplitude * (np.cos(end) - np.cos(begin))
