"""Radius against speed: the rolling radius changes with the speed of the wheel.

A soft tyre grows, or creeps on its rim, as it turns faster.

It is seen as a heading error that differs between slow and fast laps.

It is confused with the wheel's diameter where everything is driven at the same speed.

The source is a law of first order in the speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import RARE, Array, Block, Parameter, Prior, WheelEffect


@dataclass(frozen=True, slots=True)
class RadiusVsSpeed(WheelEffect):
    """The rolling radius is R (1 + slope |speed|)."""

    slope: float = 0.0  # relative change of the radius per speed of the wheel [1/(m/s)]

    name = "radius_vs_speed"
    parameters = (Parameter("slope", "1/(m/s)", null=0.0, scale=0.01, low=-1.0, high=1.0),)
    prior = Prior(RARE, discrepancy=0.1)
    regime = "speed of {component}"
    separating_drive = "the same straight at two speeds"
    says = "{part} changes its rolling radius with speed, by {slope_hundredths:.3f} % for each m/s."
    plotted_over = "speed"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the wheel's travel, scaled with its speed."""
        return (1.0 + self.slope * np.abs(block.speed[:, wheel])) * block.travel[:, wheel]
