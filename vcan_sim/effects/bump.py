"""Bump: each obstacle takes rolled way that is not travelled.

A wheel that climbs over a cable or an edge turns further than the truck travels. Seen as a sudden
heading error of lost / wheelbase; confused with a short slip patch. A stiff wheel on an edge of height h
loses 2 R (q - sin q), cos q = 1 - h / R, while it rolls 2 R q. Source: C (1)-(3), with the exact arc.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vcan_sim.effects.block import wheel_number
from vcan_sim.effects.effect import WHEEL, Effect, Parameter
from vcan_sim.errors import SimulationError

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class BumpEvents(Effect):
    """Obstacles under one wheel.

    Attributes:
        times: onset of each crossing, on the clock of the recording [s].
        lost: rolled minus travelled way of each crossing [m].
    """

    times: tuple[float, ...] = ()
    lost: tuple[float, ...] = ()

    name: ClassVar[str] = "bump"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("times", "s", null=None, scale=60.0, low=-1e12, high=1e12),
        Parameter("lost", "m", null=0.0, scale=3e-3, low=0.0, high=0.1),
    )

    def __post_init__(self) -> None:
        Effect.__post_init__(self)
        if len(self.times) != len(self.lost):
            raise SimulationError(
                f"bump of {self.component}: {len(self.times)} times, {len(self.lost)} losses; expected equal"
            )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Lose way as each crossing goes on; remember the way rolled since each onset."""
        wheel = wheel_number(self.component)
        way = np.abs(block.travel[:, wheel])
        since = np.zeros(len(self.times)) if state is None else state
        after, lost = since.copy(), np.zeros(len(block))
        for number, (time, loss) in enumerate(zip(self.times, self.lost, strict=True)):
            rolled = since[number] + np.cumsum(np.where(block.time > time, way, 0.0))
            after[number] = rolled[-1]
            radius = self.radius(block, wheel)
            under_way = since[number] < rolled[-1] and since[number] < loss + 2.0 * radius  # 2 R q at most
            if loss > 0.0 and under_way:
                way_lost = lost_after(radius, loss, np.append(since[number], rolled))
                lost += np.diff(way_lost)
        sign = np.sign(block.travel[:, wheel])
        return block.with_travel(wheel, block.travel[:, wheel] - sign * lost), after

    @staticmethod
    def radius(block: Block, wheel: int) -> float:
        """Return the wheel's nominal radius [m]: travel over turn; a common one where it stands still."""
        turned = np.abs(block.turned[:, wheel]).sum()
        return float(np.abs(block.travel[:, wheel]).sum() / turned) if turned > 0.0 else 0.075


def lost_after(radius: float, lost: float, rolled: Array) -> Array:
    """Return the way lost [m] when so much of an edge's crossing has been rolled `(K,)` [m].

    The wheel's centre swings about the edge from -q to q and travels R (sin q + sin(r / R - q)).

    Args:
        radius: R of the wheel [m].
        lost: in the whole crossing [m], more than 0.
        rolled: r since the onset [m].
    """
    q = 0.5 * crossing(radius, lost) / radius
    swung = np.clip(np.asarray(rolled) / radius, 0.0, 2.0 * q)
    return np.asarray(radius * (swung - math.sin(q) - np.sin(swung - q)))


def crossing(radius: float, lost: float) -> float:
    """Return the way rolled on an edge [m]: 2 R q with 2 R (q - sin q) = lost.

    Args:
        radius: R of the wheel [m].
        lost: in one crossing [m], more than 0.
    """
    q = (3.0 * lost / radius) ** (1.0 / 3.0)  # q - sin q = q^3 / 6 to first order
    for _ in range(20):
        q -= (2.0 * radius * (q - math.sin(q)) - lost) / (2.0 * radius * (1.0 - math.cos(q)))
    return float(2.0 * radius * q)
