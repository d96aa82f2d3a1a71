"""Bump: each obstacle takes a piece of the rolled way that is not travelled.

A wheel that climbs over a cable or an edge turns further than the truck travels. The loss grows along the
crossing as for a stiff wheel on an edge, by the law of `vcan_sim.crossing`.

It is seen as a sudden heading error of the lost way, divided by the wheelbase.

It is confused with a short slip patch.

The source is C (1)-(3), with the exact arc in place of the printed approximation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.vcan_sim.crossing import losing
from omnimate.vcan_sim.effects.block import wheel_number
from omnimate.vcan_sim.effects.effect import WHEEL, Effect, Parameter
from omnimate.vcan_sim.errors import SimulationError

if TYPE_CHECKING:
    from omnimate.vcan_sim.effects.block import Block
    from omnimate.vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class BumpEvents(Effect):
    """Obstacles under one wheel.

    Attributes:
        times: Time at which each crossing begins, on the recording's clock [s].
        lost: Way that is rolled but not travelled in each crossing [m].
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
                way_lost = losing(radius, loss).lost_after(np.append(since[number], rolled))
                lost += np.diff(way_lost)
        sign = np.sign(block.travel[:, wheel])
        return block.with_travel(wheel, block.travel[:, wheel] - sign * lost), after

    @staticmethod
    def radius(block: Block, wheel: int) -> float:
        """Return the wheel's nominal radius [m]: travel over turn; a common one where it stands still."""
        turned = np.abs(block.turned[:, wheel]).sum()
        return float(np.abs(block.travel[:, wheel]).sum() / turned) if turned > 0.0 else 0.075
