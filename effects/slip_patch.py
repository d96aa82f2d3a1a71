"""Slip patch: on a stretch of the floor the wheel turns without its full travel.

Oil, water or a loose mat lies under one wheel.

It is seen as a heading error that grows on that stretch only.

It is confused with bumps that are close to each other, and with a step of the radius where the stretch does
not end.

The source is U III: slippage as a cause of non-systematic errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from omnimate.effects.effect import FAULT, Array, Block, Parameter, Prior, VehicleParameters, WheelEffect
from omnimate.effects.words import component_in_words


@dataclass(frozen=True, slots=True)
class SlipPatch(WheelEffect):
    """Within intervals of time, the travel is (1 - fraction) of the rolled distance."""

    fraction: float = 0.0  # part of the rolled distance that is not travelled
    intervals: tuple[tuple[float, float], ...] = ()  # [s] on the recording's clock; none: always

    name = "slip_patch"
    parameters = (
        Parameter("fraction", "1", null=0.0, scale=0.05, low=0.0, high=1.0),
        Parameter("intervals", "s", null=None, scale=60.0, low=-1e12, high=1e12),
    )
    prior = Prior(FAULT, discrepancy=0.3)
    regime = "on one stretch"
    separating_drive = "the same path again: a patch of the floor is met again at the same place"
    scan = "interval"

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the travel reduced by the fraction within the intervals."""
        inside = np.full(len(block), not self.intervals)
        for start, end in self.intervals:
            inside |= (block.time > start) & (block.time <= end)
        return np.where(inside, 1.0 - self.fraction, 1.0) * block.travel[:, wheel]

    def acts_during(self, block: Block) -> tuple[float, float] | None:  # noqa: ARG002  intervals are in time
        """Return from the first interval's start to the last one's end [s]."""
        if not self.intervals:
            return None
        return min(start for start, _ in self.intervals), max(end for _, end in self.intervals)

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002
        """Return the effect in a sentence, of its first interval."""
        start, end = self.intervals[0]
        return (
            f"{component_in_words(self.component)} slipped for {end - start:.1f} s: "
            f"{100.0 * self.fraction:.1f} % of what it rolled was not travelled."
        )
