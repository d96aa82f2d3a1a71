"""A new effect: a tyre that grows while it warms up. Simulate it, and let the diagnosis find it.

Usage: python 08_new_effect.py
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import omnimate
from omnimate import effects
from omnimate.effects.block import Block, wheel_number
from omnimate.effects.effect import RARE, WHEEL, Effect, Parameter, Prior
from omnimate.motion import paths


@dataclass(frozen=True, slots=True)
class TyreWarming(Effect):
    """A wheel's radius grows towards a final value, as the tyre warms up.

    Attributes:
        growth: Final relative growth of the radius.
        time_constant: Time after which 63 % of the growth is reached [s].
    """

    growth: float = 0.0
    time_constant: float = 60.0

    name = "tyre_warming"
    stage = "travel"
    components = WHEEL
    parameters = (
        Parameter("growth", "1", null=0.0, scale=1e-3, low=-0.05, high=0.05),
        Parameter("time_constant", "s", null=None, scale=60.0, low=1.0, high=3600.0),
    )
    prior = Prior(RARE, discrepancy=0.1)
    regime = "warming up"
    separating_drive = "the same lap cold and warm"
    says = "{part} grows by {growth_hundredths:.2f} % while it warms up."

    def act(self, block: Block, state: float | None = None) -> tuple[Block, float]:
        """Lengthen the travel of the wheel; the state is the time of the first sample."""
        wheel = wheel_number(self.component)
        start = float(block.time[0]) if state is None else state
        growth = self.growth * (1.0 - np.exp(-(block.time - start) / self.time_constant))
        return block.with_travel(wheel, block.travel[:, wheel] * (1.0 + growth)), start


effects.EFFECTS.append(TyreWarming)  # in the library: a line in effects/__init__.py

drive = paths.figure_eight(laps=8)
effect = TyreWarming("a.left", growth=0.006)
recording = omnimate.simulate(program=drive, effects=[effect], seed=1)
diagnosis = omnimate.diagnose([recording])
print(diagnosis.says)
