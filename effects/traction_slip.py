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
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import wheels_of
from omnimate.effects.effect import FAULT, TRUCK, WHEEL, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class TractionSlip(Effect):
    """The travelled speed is v - compliance a |v|.

    Attributes:
        compliance: Slip per acceleration [s^2/m].
    """

    compliance: float = 0.0

    name: ClassVar[str] = "traction_slip"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = (*WHEEL, *TRUCK)
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("compliance", "s^2/m", null=0.0, scale=0.05, low=0.0, high=10.0),
    )
    prior: ClassVar[Prior] = Prior(FAULT, discrepancy=0.2)
    regime: ClassVar[str] = "accelerating and braking"
    separating_drive: ClassVar[str] = "hard starts and stops on a straight"
    says: ClassVar[str] = (
        "{part} slips in proportion to its acceleration (compliance {compliance:.4g} s^2/m)."
    )
    plotted_over: ClassVar[Abscissa] = "speed"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Take the slip away from the travel of the wheel, or of both wheels of the truck."""
        for wheel in wheels_of(self.component):
            slipped = (
                self.compliance * block.acceleration[:, wheel] * np.abs(block.speed[:, wheel]) * block.period
            )
            block = block.with_travel(wheel, block.travel[:, wheel] - slipped)
        return block, state
