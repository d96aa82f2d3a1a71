"""Slip patch: on a stretch the wheel turns without full travel.

Oil, water or a loose mat under one wheel. Seen as a heading error that grows on that stretch only;
confused with bumps close to each other, and with a step of the radius where it does not end. Source: U
III (slippage as a non-systematic error).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vcan_sim.effects.block import wheel_number
from vcan_sim.effects.effect import WHEEL, Effect, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class SlipPatch(Effect):
    """Travel (1 - fraction) of what is rolled, within intervals.

    Attributes:
        fraction: of what is rolled that is not travelled.
        intervals: (start, end) on the clock of the recording [s]; always, where there are none.
    """

    fraction: float = 0.0
    intervals: tuple[tuple[float, float], ...] = ()

    name: ClassVar[str] = "slip_patch"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("fraction", "1", null=0.0, scale=0.05, low=0.0, high=1.0),
        Parameter("intervals", "s", null=None, scale=60.0, low=-1e12, high=1e12),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Take the fraction away from the travel on the stretches."""
        wheel = wheel_number(self.component)
        inside = np.full(len(block), not self.intervals)
        for start, end in self.intervals:
            inside |= (block.time > start) & (block.time <= end)
        factor = np.where(inside, 1.0 - self.fraction, 1.0)
        return block.with_travel(wheel, factor * block.travel[:, wheel]), state
