"""Latency: the samples of one channel are old when they are sent.

The encoder has a slow filter, or its node answers late. For poses, the system that measures them is late.

It is seen as an error in proportion to the rate at which the channel changes.

It is confused with traction slip (wheels) and with backlash (joints).

The source is a constant delay.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.ageing import SYNC_SKEW, AgedSamples
from omnimate.effects.effect import FAULT, POSES, Array, Parameter, Prior


@dataclass(frozen=True, slots=True)
class Latency(AgedSamples):
    """Every sample is the value of an earlier time."""

    delay: float = 0.0  # age of every sample [s]

    name = "latency"
    parameters = (Parameter("delay", "s", null=0.0, scale=0.02, low=0.0, high=2.0),)
    # The largest, 0.2 s, is that of a node that is asked five times a second.
    prior = Prior(FAULT, background=0.25, largest=10.0)
    regime = "in proportion to the rate of {component}"
    separating_drive = "a slalom with quick changes of the turn rate"
    says = "{part} sends samples that are {delay:.4f} s old."
    plotted_over = "turn rate"
    sizes = (1.0, 4.0)
    excited_by = "channel motion"
    startup_nuisance = "always"
    relative = True

    def age(self, time: Array, _start: float) -> Array:
        """Return the age of samples [s]."""
        return np.full(len(time), self.delay)

    @classmethod
    def background(cls, component: str) -> float:
        """Return the nominal spread of delays in units of `scale`; small for encoders on one SYNC."""
        return cls.prior.background if component in POSES else SYNC_SKEW / cls.estimated().scale
