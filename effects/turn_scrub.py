"""Turn scrub: the effective wheelbase depends on the curvature that is driven.

In tight turns wide tyres are dragged sideways about their contact. The wheelbase is b (1 + slope
|curvature|), with the curvature |yaw rate| / sqrt(v^2 + (b yaw rate / 2)^2), which stays finite for a turn
on the spot.

It is seen as a wheelbase that differs between arcs and turns on the spot.

It is confused with the wheelbase where all turns are alike.

The source is a law of first order in the curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import RARE, Array, Block, Parameter, Prior, TruckEffect


@dataclass(frozen=True, slots=True)
class TurnScrub(TruckEffect):
    """The effective wheelbase is b (1 + slope |curvature|)."""

    slope: float = 0.0  # relative growth of the wheelbase per curvature [m]

    name = "turn_scrub"
    parameters = (Parameter("slope", "m", null=0.0, scale=0.005, low=-1.0, high=1.0),)
    prior = Prior(RARE, background=0.01, discrepancy=0.1)
    regime = "turning, by curvature"
    separating_drive = "arcs of two radii, and a turn on the spot"
    says = "{part} scrubs in turns: its wheelbase grows by {slope_hundredths:.2f} % per 1/m of curvature."
    plotted_over = "turn rate"
    excited_by = "turns"

    def change(self, twist: Array, block: Block, truck: int) -> None:
        """Divide the yaw by the relative growth of the wheelbase."""
        across = 0.5 * block.wheelbase[truck] * twist[:, 2]
        distance = np.sqrt(twist[:, 0] ** 2 + across**2)
        curvature = np.abs(twist[:, 2]) / np.maximum(distance, 1e-12)
        twist[:, 2] /= 1.0 + self.slope * curvature
