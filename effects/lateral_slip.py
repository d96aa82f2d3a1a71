"""Lateral slip: the truck creeps sideways in proportion to its lateral acceleration.

Tyres need a slip angle to carry the centripetal force. The sideways speed, outwards, is compliance v yaw
rate.

It is seen in fast arcs.

It is confused with a slope of the floor where arcs are driven in one direction only.

The source is a tyre of linear cornering stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import RARE, Array, Block, Parameter, Prior, TruckEffect


@dataclass(frozen=True, slots=True)
class LateralSlip(TruckEffect):
    """The sideways speed, outwards, is compliance v yaw rate."""

    compliance: float = 0.0  # sideways speed per lateral acceleration [s]

    name = "lateral_slip"
    parameters = (Parameter("compliance", "s", null=0.0, scale=0.02, low=0.0, high=10.0),)
    prior = Prior(RARE, discrepancy=0.2)
    regime = "turning, by speed times yaw rate"
    separating_drive = "the same arc at two speeds"
    says = "{part} creeps outwards in turns (compliance {compliance:.4g} s)."
    plotted_over = "speed"

    def change(self, twist: Array, block: Block, truck: int) -> None:  # noqa: ARG002
        """Creep outwards: to the right in a turn to the left."""
        twist[:, 1] -= self.compliance * twist[:, 0] * twist[:, 2] / block.period
