"""Clock drift: one clock runs faster or slower than the other.

A node samples on its own clock, or the poses are stamped by another computer. The age of the samples is
rate times the time since the start.

It is seen as a latency that grows.

It is confused with a constant latency in short recordings.

The source is a constant rate between two clocks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.effect import FAULT, POSES, Array, Parameter, Prior

# [1] An encoder that answers SYNC rarely has a free clock: odds are lower than for poses by this
# (assumption).
SYNCHRONISED_ODDS_FACTOR = 10.0


@dataclass(frozen=True, slots=True)
class ClockDrift(AgedSamples):
    """The age of the samples grows with time."""

    rate: float = 0.0  # age that the samples gain per time [s/s]

    name = "clock_drift"
    parameters = (Parameter("rate", "1", null=0.0, scale=2e-4, low=-0.1, high=0.1),)
    prior = Prior(FAULT, background=0.02, largest=10.0)
    regime = "time"
    separating_drive = "a drive three times as long"
    says = "the clock of {part} runs off by {rate_hundredths:.4f} %."
    excited_by = "channel motion"
    relative = True

    def age(self, time: Array, start: float) -> Array:
        """Return the age of samples [s]."""
        return np.asarray(self.rate * (time - start))

    @classmethod
    def log_odds(cls, component: str) -> float:
        """Return the log prior odds, lower for encoders, which sample on SYNC."""
        return cls.prior.log_odds - (0.0 if component in POSES else math.log(SYNCHRONISED_ODDS_FACTOR))
