"""Pushes: what moves a truck at one moment, and is no obstacle under one wheel.

Somebody leans against the robot, a slider comes free, a cable pulls. Nothing is assumed of it but that it is
short: the truck is displaced and turned by any amount. It stands against every event with a name.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.mismatch.candidates.beliefs import BELIEFS
from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.recording.signals import WINDOW
from omnimate.vcan_sim.effects.block import truck_number
from omnimate.vcan_sim.effects.effect import TRUCK, Effect

if TYPE_CHECKING:
    from omnimate.vcan_sim.effects.block import Block
    from omnimate.vcan_sim.effects.effect import Parameter, Stage
    from omnimate.vehicle.se2 import Array

SHOVE = (3e-3, 3e-3, 1e-2)  # [m, m, rad] forward, to the left and round, one standard deviation
MOMENTS = "single moments"


@dataclass(frozen=True, slots=True)
class Push(Effect):
    """A truck is displaced and turned within a window.

    Attributes:
        time: Start of the window [s].
        moved: Way forward [m], way to the left [m], and turn [rad].
    """

    time: float = 0.0
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)

    name: ClassVar[str] = "unknown"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Spread the push evenly over the steps of its window."""
        inside = (block.time > self.time) & (block.time <= self.time + WINDOW)
        if not inside.any():
            return block, state
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        twist[inside] += np.array(self.moved) / int(inside.sum())
        return block.with_twist(truck, twist), state


@dataclass(frozen=True, slots=True)
class PushTerm(Term):
    """A push as a candidate of three columns."""

    def built(self, coefficients: Array) -> Push:
        """Return the push with these coefficients `(3,)`."""
        moved = coefficients * np.array(SHOVE)
        return Push(self.component, self.fixed["times"][0], (moved[0], moved[1], moved[2]))

    def fine(self) -> Term:
        """Return itself: a push is linear."""
        return self


def push(truck: str, time: float, tries: int) -> PushTerm:
    """Return the candidate of a push.

    Args:
        truck: Truck that is pushed.
        time: Start of the window in which it is [s].
        tries: Windows among which it was looked for.
    """
    axes = np.diag(SHOVE).tolist()
    probes = tuple(Push(truck, time, (axis[0], axis[1], axis[2])) for axis in axes)
    odds = BELIEFS["unknown"].log_odds - math.log(tries)
    fixed = {"times": (time,), "quantity": MOMENTS, "acts_on": ""}
    return PushTerm("unknown", truck, probes, fixed, odds, positive=False)
