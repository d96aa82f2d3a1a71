"""Wheelbase: the truck turns as if its wheels stood closer together or further apart.

Tyres touch the floor in an area and not in a point, so that the effective wheelbase is uncertain (U II).

It is seen in turns only.

It is confused with unequal wheel diameters on squares that are driven one way only, because these
compensate it there.

The source is U (2.5) and (4.4).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from omnimate.effects.block import truck_number
from omnimate.effects.effect import MISCALIBRATED, TRUCK, Effect, Parameter, Prior
from omnimate.effects.words import component_in_words

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage, Startup
    from omnimate.vehicle.parameters import VehicleParameters


@dataclass(frozen=True, slots=True)
class Wheelbase(Effect):
    """The effective wheelbase is the nominal one, multiplied by a ratio.

    Attributes:
        ratio: True wheelbase, divided by the nominal one.
    """

    ratio: float = 1.0

    name: ClassVar[str] = "wheelbase"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.01, low=0.5, high=2.0),
    )
    prior: ClassVar[Prior] = Prior(MISCALIBRATED, background=0.03, discrepancy=0.02)
    regime: ClassVar[str] = "turning"
    separating_drive: ClassVar[str] = "turns on the spot in both directions with the heading measured"
    plotted_over: ClassVar[Abscissa] = "turn rate"
    startup_nuisance: ClassVar[Startup | None] = "always"
    calibrated: ClassVar[bool] = True
    alternatives: ClassVar[tuple[str, ...]] = ("turn_scrub",)

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Divide the yaw by the ratio."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        twist[:, 2] /= self.ratio
        return block.with_twist(truck, twist), state

    def describe(self, vehicle: VehicleParameters) -> str:
        """Return the effect in a sentence, with the true and the nominal wheelbase [mm]."""
        nominal = 1e3 * vehicle.trucks[self.component].wheelbase  # type: ignore[index]
        return (
            f"{component_in_words(self.component)} turns as if its wheelbase were "
            f"{self.ratio * nominal:.2f} mm, not {nominal:.2f} mm ({(self.ratio - 1.0) * 100.0:+.2f} %)."
        )
