"""Radius step: the rolling radius of a wheel changes at one moment.

A payload moves, or a tyre loses air.

It is seen as a wheel diameter that holds from that moment on.

It is confused with a slip patch that does not end.

The source is a step of the radius in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import FAULT, WHEEL, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Scan, Stage


@dataclass(frozen=True, slots=True)
class RadiusStep(Effect):
    """The rolling radius is R before a moment and ratio R after it.

    Attributes:
        ratio: Radius after the moment, divided by the radius before it.
        time: Moment of the step, on the recording's clock [s].
    """

    ratio: float = 1.0
    time: float = 0.0

    name: ClassVar[str] = "radius_step"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("ratio", "1", null=1.0, scale=0.005, low=0.5, high=2.0),
        Parameter("time", "s", null=None, scale=60.0, low=-1e12, high=1e12),
    )
    prior: ClassVar[Prior] = Prior(FAULT)
    regime: ClassVar[str] = "from one moment on"
    separating_drive: ClassVar[str] = "the same lap before and after the moment"
    says: ClassVar[str] = (
        "{part} changes its rolling radius at one moment, by {ratio_percent:+.3f} %: "
        "a load moved or a tyre lost air."
    )
    scan: ClassVar[Scan | None] = "step"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Scale the wheel's travel in the steps that end after the moment."""
        wheel = wheel_number(self.component)
        factor = np.where(block.time > self.time, self.ratio, 1.0)
        return block.with_travel(wheel, factor * block.travel[:, wheel]), state
