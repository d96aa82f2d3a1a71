"""Latency: the samples of one channel are old when they are sent.

A slow filter, or a node that answers late. Seen in proportion to the channel's rate of change; confused
with traction slip (wheels) and with backlash (joints). Source: a delay.
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
class Latency(AgedSamples):
    """Samples of an earlier time.

    Attributes:
        delay: age of every sample [s].
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
