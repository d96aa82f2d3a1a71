"""Castor kick: the truck yaws each time its direction of travel reverses.

Castors swing round when the truck reverses, and push it sideways while they do. Single kicks scatter; this is
their mean. `swing` is the distance over which they come; without it the truck yaws at once.

It is seen as a step of the heading at reversals only.

It is confused with backlash in the gears of the wheels.

The source is U III-C: castors as a cause of non-systematic errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.block import truck_number
from omnimate.effects.effect import FAULT, TRUCK, Array, Block, Drive, Effect, Parameter, Prior
from omnimate.effects.play import play_output

REVERSAL_DISTANCE = 1e-3  # [m] smallest motion back that counts as a reversal: above the noise of counts

if TYPE_CHECKING:
    from numpy.typing import NDArray

SWING_DISTANCES = (0.0, 0.05, 0.15)  # [m] trial values: up to a few times a castor's trail (assumption)


@dataclass(frozen=True, slots=True)
class CastorKick(Effect):
    """The truck yaws at every reversal of its travel."""

    yaw: float = 0.0  # yaw at each reversal [rad]
    swing: float = 0.0  # distance after a reversal over which the truck yaws [m]; 0 where it yaws at once

    name = "castor_kick"
    stage = "body"
    components = TRUCK
    parameters = (
        Parameter("yaw", "rad", null=0.0, scale=0.003, low=-1.0, high=1.0),
        Parameter("swing", "m", null=None, scale=0.05, low=0.0, high=1.0),
    )
    prior = Prior(FAULT, background=0.1, discrepancy=0.3)
    regime = "at reversals of travel"
    separating_drive = "ten reversals on one straight"
    says = "{part} yaws by {yaw:+.3f} degrees each time it reverses: its castors swing round."

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the yaw after each reversal; the state is travel, filtered travel, its sign, distance since."""
        truck = truck_number(self.component)
        start, followed, last, since = (0.0, 0.0, 0.0, np.inf) if state is None else state
        distance = start + np.cumsum(block.twist[:, truck, 0])
        steady = play_output(distance, followed, 2.0 * REVERSAL_DISTANCE)
        moved = np.sign(np.diff(np.concatenate(([followed], steady))))
        known = np.concatenate(([last], moved))
        before = known[np.maximum.accumulate(np.where(known != 0.0, np.arange(len(known)), 0))]
        reversed_ = (moved != 0.0) & (before[:-1] != 0.0) & (moved != before[:-1])
        twist = block.twist[:, truck].copy()
        shares, since = self._swung(reversed_, np.abs(block.twist[:, truck, 0]), since)
        twist[:, 2] += self.yaw * shares
        state = float(distance[-1]), float(steady[-1]), float(before[-1]), since
        return block.with_twist(truck, twist), state

    def _swung(self, reversed_: NDArray[np.bool_], distances: Array, since: float) -> tuple[Array, float]:
        """Return the share of the yaw in each step, and the distance since the last reversal [m].

        `reversed_` says whether the truck reverses in each step and `distances` how far it goes [m], each
        `(K,)`; `since` is the distance since the last reversal before the first step [m].
        """
        if self.swing == 0.0:
            return reversed_.astype(np.float64), since
        total = np.cumsum(distances)
        last_reversal = np.maximum.accumulate(np.where(reversed_, np.arange(len(distances)), -1))
        # distance at the last reversal
        turned = np.where(last_reversal >= 0, total[last_reversal] - distances[last_reversal], -since)
        after = np.minimum(total - turned, self.swing)
        before = np.minimum(total - distances - turned, self.swing)
        return (after - before) / self.swing, float(total[-1] - turned[-1])

    @classmethod
    def grid(cls, drive: Drive) -> list[dict[str, float]]:  # noqa: ARG003
        """Return distances over which castors swing round."""
        return [{"swing": swing} for swing in SWING_DISTANCES]
