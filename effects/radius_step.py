"""Radius step: the rolling radius of a wheel changes at one moment.

A payload moves, or a tyre loses air.

It is seen as a wheel diameter that holds from that moment on.

It is confused with a slip patch that does not end.

The source is a step of the radius in time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, Array, Block, Parameter, Prior, WheelEffect


@dataclass(frozen=True, slots=True)
class RadiusStep(WheelEffect):
    """The rolling radius is R before a moment and ratio R after it."""

    ratio: float = 1.0  # radius after the moment, divided by the radius before it
    time: float = 0.0  # moment of the step, on the recording's clock [s]

    name = "radius_step"
    parameters = (
        Parameter("ratio", "1", null=1.0, scale=0.005, low=0.5, high=2.0),
        Parameter("time", "s", null=None, scale=60.0, low=-1e12, high=1e12),
    )
    prior = Prior(FAULT)
    regime = "from one moment on"
    separating_drive = "the same lap before and after the moment"
    says = (
        "{part} changes its rolling radius at one moment, by {ratio_percent:+.3f} %: "
        "a load moved or a tyre lost air."
    )
    scan = "step"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the wheel's travel, scaled in the steps that end after the moment."""
        return np.where(block.time > self.time, self.ratio, 1.0) * block.travel[:, wheel]
