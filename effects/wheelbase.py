"""Wheelbase: the truck turns as if its wheels stood closer together or further apart.

Tyres touch the floor in an area and not in a point, so that the effective wheelbase is uncertain (U II).

It is seen in turns only.

It is confused with unequal wheel diameters on squares that are driven in one direction only, because these
compensate it there.

The source is U (2.5) and (4.4).
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import (
    MISCALIBRATED,
    Array,
    Block,
    Parameter,
    Prior,
    TruckEffect,
    VehicleParameters,
)
from omnimate.effects.words import component_in_words


@dataclass(frozen=True, slots=True)
class Wheelbase(TruckEffect):
    """The effective wheelbase is the nominal one, multiplied by a ratio."""

    ratio: float = 1.0  # true wheelbase, divided by the nominal one

    name = "wheelbase"
    parameters = (Parameter("ratio", "1", null=1.0, scale=0.01, low=0.5, high=2.0),)
    prior = Prior(MISCALIBRATED, background=0.03, discrepancy=0.02)
    regime = "turning"
    separating_drive = "turns on the spot in both directions with the heading measured"
    plotted_over = "turn rate"
    startup_nuisance = "always"
    calibrated = True
    alternatives = ("turn_scrub",)

    def change(self, twist: Array, block: Block, truck: int) -> None:  # noqa: ARG002
        """Divide the yaw by the ratio."""
        twist[:, 2] /= self.ratio

    def describe(self, vehicle: VehicleParameters) -> str:
        """Return the effect in a sentence, with the true and the nominal wheelbase [mm]."""
        nominal = 1e3 * vehicle.trucks[self.component].wheelbase  # type: ignore[index]
        return (
            f"{component_in_words(self.component)} turns as if its wheelbase were "
            f"{self.ratio * nominal:.2f} mm, not {nominal:.2f} mm ({(self.ratio - 1.0) * 100.0:+.2f} %)."
        )
