"""Bump: on each obstacle a part of the rolled distance is not travelled.

A wheel that climbs over a cable or an edge turns further than the truck travels. The loss grows along the
crossing as for a stiff wheel on an edge, by the law of `effects.crossing`.

It is seen as a sudden heading error of the lost travel, divided by the wheelbase.

It is confused with a short slip patch. Any floor has edges of 0.9 mm, at which a wheel loses 0.09 mm.

The source is C (1)-(3), with the exact arc in place of the printed approximation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimate.effects.block import wheel_number, wheel_radius
from omnimate.effects.crossing import crossing_with_loss
from omnimate.effects.effect import FAULT, WHEEL, Block, Effect, Parameter, Prior, VehicleParameters
from omnimate.effects.errors import EffectError
from omnimate.effects.words import component_in_words


@dataclass(frozen=True, slots=True)
class BumpEvents(Effect):
    """Obstacles under one wheel."""

    times: tuple[float, ...] = ()  # time at which each crossing begins, on the recording's clock [s]
    lost: tuple[float, ...] = ()  # travel that is rolled but not travelled in each crossing [m]

    name = "bump"
    stage = "travel"
    components = WHEEL
    parameters = (
        Parameter("times", "s", null=None, scale=60.0, low=-1e12, high=1e12),
        Parameter("lost", "m", null=0.0, scale=3e-3, low=0.0, high=0.1),
    )
    prior = Prior(FAULT, background=0.03, discrepancy=0.3, largest=6.0)
    regime = "at single moments"
    separating_drive = "the same path again: what lies on the floor is met again at the same place"
    scan = "moments"
    linear = "lost"

    def __post_init__(self) -> None:
        Effect.__post_init__(self)
        if len(self.times) != len(self.lost):
            raise EffectError(
                f"bump of {self.component}: {len(self.times)} times, {len(self.lost)} losses; expected equal"
            )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Subtract the loss of each crossing; the state is the distance rolled since each onset.

        Without a state, crossings that began before the block are over.
        """
        wheel = wheel_number(self.component)
        travel, radius = block.travel[:, wheel], wheel_radius(block, wheel)
        distance = np.concatenate(([0.0], np.cumsum(np.abs(travel))))
        begun = np.array(self.times) < block.time[0] - block.period[0]
        since = np.where(begun, np.inf, 0.0) if state is None else state
        after, lost = since.copy(), np.zeros(len(block))
        for number, (time, loss) in enumerate(zip(self.times, self.lost, strict=True)):
            first = int(np.searchsorted(block.time, time, side="right"))
            before = distance[first] - since[number]  # distance at which the crossing began
            after[number] = distance[-1] - before
            if loss > 0.0 and since[number] < after[number]:
                crossing = crossing_with_loss(radius, loss)
                last = int(np.searchsorted(distance, before + crossing.rolled)) + 1
                lost[first : last - 1] += np.diff(crossing.lost_after(distance[first:last] - before))
        return block.with_travel(wheel, travel - np.sign(travel) * lost), after

    def acts_during(self, block: Block) -> tuple[float, float] | None:
        """Return start of the first and end of the last crossing [s]."""
        wheel = wheel_number(self.component)
        distance = np.cumsum(np.abs(block.travel[:, wheel]))
        ends = [self.times[0]] if self.times else []
        for time, loss in zip(self.times, self.lost, strict=True):
            first = int(np.searchsorted(block.time, time, side="right"))
            begun = distance[first - 1] if first > 0 else 0.0
            rolled = crossing_with_loss(wheel_radius(block, wheel), loss).rolled if loss > 0.0 else 0.0
            last = min(int(np.searchsorted(distance, begun + rolled)), len(block) - 1)
            ends.append(float(block.time[last]))
        return (min(self.times), max(ends)) if ends else None

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002
        """Return the effect in a sentence, with the mean lost travel [mm]."""
        lost = [1e3 * loss for loss in self.lost]
        many = f"{len(lost)} bumps" if len(lost) > 1 else "a bump"
        return (
            f"{component_in_words(self.component)} went over {many}: each time it rolled about "
            f"{sum(lost) / max(len(lost), 1):.2f} mm that the truck did not travel."
        )
