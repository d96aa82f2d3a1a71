"""Floor slope: the truck creeps towards one direction of the floor.

On a tilted floor tyres creep downhill, sideways or lengthwise, by a part of the distance driven. On oil, wet
paint or another film that yields, they creep all the time, and also while the truck stands.

It is seen as a displacement whose direction in the truck's frame turns with the heading. The linkage alone
does not show it where both trucks creep alike.

It is confused with lateral slip and with wheel misalignment where the heading hardly changes.

The source is creep in proportion to the force along the slope.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import (
    FAULT,
    Array,
    Block,
    Drive,
    Effect,
    Parameter,
    Prior,
    TruckEffect,
    VehicleParameters,
)
from omnimate.effects.words import component_in_words

FILM_DISCREPANCY = 0.15  # [1] relative error of creep on a film, stated for a mean speed (assumption)


@dataclass(frozen=True, slots=True)
class FloorSlope(TruckEffect):
    """The truck creeps towards one direction of the floor."""

    rate: float = 0.0  # creep per metre travelled
    direction: float = 0.0  # direction of the creep in the world, counter-clockwise from x [rad]
    # Speed of travel at which a yielding film lets the truck creep by `rate`, and with the same speed while
    # it stands [m/s]; 0 where the creep goes with the distance driven
    pace: float = 0.0

    name = "floor_slope"
    parameters = (
        Parameter("rate", "1", null=0.0, scale=0.005, low=0.0, high=1.0),
        Parameter("direction", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
        Parameter("pace", "m/s", null=None, scale=0.3, low=0.0, high=20.0),
    )
    # 3 %: a ramp of 1 in 12 (ADA Standards 405.2), of which soft tyres creep by a third
    prior = Prior(FAULT, background=0.03, discrepancy=0.1, largest=6.0)
    regime = "heading on the floor"
    separating_drive = "the same straight in four directions of the floor, with absolute poses"
    plotted_over = "heading"
    startup_nuisance = "with poses"

    def change(self, twist: Array, block: Block, truck: int) -> None:
        """Add the creep in the truck's frame."""
        creep = self.rate * (self.pace * block.period if self.pace else np.abs(twist[:, 0]))
        angle = self.direction - block.heading[:, truck]
        twist[:, 0] += creep * np.cos(angle)
        twist[:, 1] += creep * np.sin(angle)

    @classmethod
    def grid(cls, drive: Drive) -> list[dict[str, float]]:
        """Return trial values of `pace`: creep in proportion to distance, and to time."""
        return [{"pace": 0.0}, {"pace": drive.pace}]

    def discrepancy(self) -> float:
        """Return the relative error of the creep over a recording, one standard deviation."""
        return FILM_DISCREPANCY if self.pace else Effect.discrepancy(self)

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002
        """Return the effect in a sentence, with the direction [degrees] and the creep [mm/s] or [%]."""
        part = component_in_words(self.component)
        towards = f"towards {math.degrees(self.direction):.0f} degrees of the floor"
        if self.pace:
            creep = 1e3 * self.rate * self.pace
            return (
                f"{part} creeps at {creep:.2f} mm/s {towards}, also where it stands: "
                "it slopes, under tyres or a film that give way."
            )
        return f"{part} creeps {100.0 * self.rate:.3f} % of its way {towards}: it slopes."
