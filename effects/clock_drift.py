"""Clock drift: one clock runs faster or slower than the other.

A node samples on its own clock, or the poses are stamped by another computer. The age of the samples is
rate times the time since the start.

It is seen as a latency that grows.

It is confused with a constant latency in short recordings.

The source is a constant rate between two clocks.
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
class ClockDrift(AgedSamples):
    """Every sample is the value of a time that lies back further and further.

    Attributes:
        rate: Age that the samples gain per time [s/s].
    """

    rate: float = 0.0

    name: ClassVar[str] = "clock_drift"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = (*WHEEL, *JOINT, *LINK, *POSES)
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("rate", "1", null=0.0, scale=2e-4, low=-0.1, high=0.1),
    )

    def age(self, time: Array, start: float) -> Array:
        """Return how old samples are [s]."""
        return np.asarray(self.rate * (time - start))
