"""Count loss: above a speed, a part of the counts of a wheel's encoder is lost.

The reader, the cable or the counter's input is too slow for the edges.

It is seen as a wheel that counts too little for the distance that it rolls, at high speed only.

It is confused with a radius that changes with the speed.

The source is a threshold of the speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import FAULT, WHEEL, Block, Drive, Effect, Parameter, Prior


@dataclass(frozen=True, slots=True)
class CountLoss(Effect):
    """A fraction of the counts is lost while the wheel is faster than a speed."""

    fraction: float = 0.0  # part of the counts that never arrives
    above: float = 0.1  # speed of the wheel above which counts are lost [m/s]

    name = "count_loss"
    stage = "encoder"
    components = WHEEL
    parameters = (
        Parameter("fraction", "1", null=0.0, scale=0.01, low=0.0, high=0.99),
        Parameter("above", "m/s", null=None, scale=0.2, low=0.0, high=100.0),
    )
    prior = Prior(FAULT, background=0.01, discrepancy=0.1)
    regime = "speed of {component}"
    separating_drive = "the same straight slowly and at full speed"
    says = "{part} loses {fraction_hundredths:.2f} % of its counts while faster than {above:.3g} m/s."
    plotted_over = "speed"
    scan = "threshold"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Subtract the lost counts from the counted angle; the state is their sum."""
        wheel = wheel_number(self.component)
        fast = np.abs(block.speed[:, wheel]) > self.above
        counted = np.where(fast, 1.0 - self.fraction, 1.0) * block.turned[:, wheel]
        missing = (0.0 if state is None else state) + np.cumsum(block.turned[:, wheel] - counted)
        return block.with_counted(wheel, block.angle[:, wheel] - missing, counted), float(missing[-1])

    def recover(self, block: Block) -> Block:
        """Return the block with the uncounted travel added."""
        wheel = wheel_number(self.component)
        fast = np.abs(block.speed[:, wheel]) > self.above * (1.0 - self.fraction)
        factor = np.where(fast, 1.0 / (1.0 - self.fraction), 1.0)
        return block.with_travel(wheel, factor * block.travel[:, wheel])

    @classmethod
    def grid(cls, drive: Drive) -> list[dict[str, float]]:
        """Return thresholds at quantiles of the wheel's speed."""
        return [{"above": speed} for speed in drive.speeds]
