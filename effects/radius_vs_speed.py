"""Radius against speed: the rolling radius changes with the speed of the wheel.

A soft tyre grows, or creeps on its rim, as it turns faster.

It is seen as a heading error that differs between slow and fast laps.

It is confused with the wheel's diameter where everything is driven at the same speed.

The source is a law of first order in the speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import RARE, WHEEL, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class RadiusVsSpeed(Effect):
    """The rolling radius is R (1 + slope |speed|).

    Attributes:
        slope: Relative change of the radius per speed of the wheel [1/(m/s)].
    """

    slope: float = 0.0

    name: ClassVar[str] = "radius_vs_speed"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("slope", "1/(m/s)", null=0.0, scale=0.01, low=-1.0, high=1.0),
    )
    prior: ClassVar[Prior] = Prior(RARE, discrepancy=0.1)
    regime: ClassVar[str] = "speed of {component}"
    separating_drive: ClassVar[str] = "the same straight at two speeds"
    says: ClassVar[str] = (
        "{part} changes its rolling radius with speed, by {slope_hundredths:.3f} % for each m/s."
    )
    plotted_over: ClassVar[Abscissa] = "speed"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Scale the wheel's travel with its speed."""
        wheel = wheel_number(self.component)
        factor = 1.0 + self.slope * np.abs(block.speed[:, wheel])
        return block.with_travel(wheel, factor * block.travel[:, wheel]), state
