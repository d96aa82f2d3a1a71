"""Latency: the samples of one channel are old when they are sent.

The encoder has a slow filter, or its node answers late. For poses, the system that measures them is late.

It is seen as an error in proportion to the rate at which the channel changes.

It is confused with traction slip (wheels) and with backlash (joints).

The source is a constant delay.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.effect import JOINT, LINK, POSES, WHEEL, Parameter

if TYPE_CHECKING:
    from omnimate.effects.effect import Stage
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Latency(AgedSamples):
    """Every sample is the value of an earlier time.

    Attributes:
        delay: Age of every sample [s].
    """

    delay: float = 0.0

    name: ClassVar[str] = "latency"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = (*WHEEL, *JOINT, *LINK, *POSES)
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("delay", "s", null=0.0, scale=0.02, low=0.0, high=2.0),
    )

    def age(self, time: Array, _start: float) -> Array:
        """Return how old samples are [s]."""
        return np.full(len(time), self.delay)
