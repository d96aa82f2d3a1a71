"""Traction slip: a driven wheel slips in proportion to its acceleration.

Rubber has to slip to pass on a force. The travelled speed is v - compliance a |v|, with the acceleration a
of the wheel.

It is seen where the robot starts and stops.

It is confused with the latency of a wheel's encoder.

The source is the linear part of the tyre's slip curve (Pacejka, Tire and Vehicle Dynamics, 2012, chapter
1).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, TRUCK, WHEEL, Array, Block, Parameter, Prior, WheelEffect


@dataclass(frozen=True, slots=True)
class TractionSlip(WheelEffect):
    """The travelled speed is v - compliance a |v|."""

    compliance: float = 0.0  # slip per acceleration [s^2/m]

    name = "traction_slip"
    components = (*WHEEL, *TRUCK)
    parameters = (Parameter("compliance", "s^2/m", null=0.0, scale=0.05, low=0.0, high=10.0),)
    prior = Prior(FAULT, discrepancy=0.2)
    regime = "accelerating and braking"
    separating_drive = "hard starts and stops on a straight"
    says = "{part} slips in proportion to its acceleration (compliance {compliance:.4g} s^2/m)."
    plotted_over = "speed"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the travel of a wheel minus its slip."""
        acceleration, speed = block.acceleration[:, wheel], np.abs(block.speed[:, wheel])
        return block.travel[:, wheel] - self.compliance * acceleration * speed * block.period
