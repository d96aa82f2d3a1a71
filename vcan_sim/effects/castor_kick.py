"""Castor kick: a yaw error each time the direction of travel reverses.

Castors swing round and push the truck sideways. Seen at reversals only; confused with backlash in the
wheels' gears. Single kicks scatter; this is their mean. Source: U III-C (castors as a cause of non-
systematic errors).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from vcan_sim.effects.block import truck_number
from vcan_sim.effects.effect import TRUCK, Effect, Parameter

_STILL = 0.005  # [m/s] below which a truck counts as standing: noise of counts is no reversal

if TYPE_CHECKING:
    from vcan_sim.effects.block import Block
    from vcan_sim.effects.effect import Stage


@dataclass(frozen=True, slots=True)
class CastorKick(Effect):
    """A yaw at every reversal of travel.

    Attributes:
        yaw: at each reversal [rad].
    """

    yaw: float = 0.0

    name: ClassVar[str] = "castor_kick"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("yaw", "rad", null=0.0, scale=0.003, low=-1.0, high=1.0),
    )

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Yaw in the first step after each reversal; remember the direction of travel."""
        truck = truck_number(self.component)
        forward = block.twist[:, truck, 0]
        sign = np.where(np.abs(forward) > _STILL * block.period, np.sign(forward), 0.0)
        first = 0.0 if state is None else state
        known = np.concatenate(([first], sign))
        last = known[np.maximum.accumulate(np.where(known != 0.0, np.arange(len(known)), 0))]
        reversed_ = (sign != 0.0) & (last[:-1] != 0.0) & (sign != last[:-1])
        twist = block.twist[:, truck].copy()
        twist[:, 2] += np.where(reversed_, self.yaw, 0.0)
        return block.with_twist(truck, twist), float(last[-1])
