"""Wheel diameter: a wheel's travel per turn differs from the nominal one.

Wheels wear, are pressed flat by the load, or were never measured; the two wheels of a truck then differ.

It is seen as a heading error in proportion to the distance driven, and as an error of all lengths.

It is confused with the diameter of the truck's other wheel. On closed squares that are driven in one
direction only, it is also confused with the wheelbase.

The source is U (2.3): unequal wheel diameters.
"""

from __future__ import annotations

from dataclasses import dataclass

from omnimate.effects.effect import (
    MISCALIBRATED,
    Array,
    Block,
    Parameter,
    Prior,
    VehicleParameters,
    WheelEffect,
)
from omnimate.effects.words import component_in_words


@dataclass(frozen=True, slots=True)
class WheelDiameter(WheelEffect):
    """The wheel's travel is multiplied by a ratio."""

    ratio: float = 1.0  # true circumference of the wheel, divided by the nominal one

    name = "wheel_diameter"
    parameters = (Parameter("ratio", "1", null=1.0, scale=0.01, low=0.5, high=2.0),)
    prior = Prior(MISCALIBRATED, background=0.01, discrepancy=0.01)
    regime = "in proportion to the way rolled"
    separating_drive = "long straights with the heading measured at both ends"
    startup_nuisance = "always"
    calibrated = True
    alternatives = ("slip_patch",)

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the wheel's travel, scaled."""
        return self.ratio * block.travel[:, wheel]

    def describe(self, vehicle: VehicleParameters) -> str:
        """Return the effect in a sentence, with the true and the nominal diameter [mm]."""
        nominal = 1e3 * vehicle.wheel_diameter(self.component)  # type: ignore[arg-type]
        return (
            f"{component_in_words(self.component)} rolls {abs(self.ratio - 1.0) * 100.0:.3f} % "
            f"{'more' if self.ratio > 1.0 else 'less'} per turn than vehicle.toml says: "
            f"its diameter is {self.ratio * nominal:.3f} mm, not {nominal:.3f} mm."
        )
