"""Clock drift: one clock runs faster or slower than the other.

A node that samples on a clock of its own, or poses stamped by another computer: samples age by rate x
time since the start. Seen as latency that grows. Source: a rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from vcan_sim.effects.ageing import AgedSamples
from vcan_sim.effects.effect import JOINT, LINK, POSES, WHEEL, Parameter

if TYPE_CHECKING:
    from vcan_sim.effects.effect import Stage
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class ClockDrift(AgedSamples):
    """Samples of an earlier time.

    Attributes:
        rate: age gained per time [s/s].
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
