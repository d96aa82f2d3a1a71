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
    """A truck is displaced and turned within some time.

    Attributes:
        time: When it begins [s].
        lasting: How long it lasts [s].
        moved: Way forward [m], way to the left [m], and turn [rad].
    """

    time: float = 0.0
    lasting: float = WINDOW
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)

    name: ClassVar[str] = "unknown"
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Spread the push evenly over its steps."""
        inside = (block.time > self.time) & (block.time <= self.time + self.lasting)
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
        return Push(
            self.component, self.fixed["times"][0], self.fixed["lasting"], (moved[0], moved[1], moved[2])
        )

    @property
    def inexact(self) -> float:
        """A push has no shape: what else is seen while it lasts says nothing of other effects."""
        return 1.0

    @property
    def stretches(self) -> list[tuple[float, float]]:
        """From when to when it acts [s]."""
        return [(time, time + self.fixed["lasting"]) for time in self.fixed["times"]]

    def fine(self) -> Term:
        """Return itself: a push is linear."""
        return self


def push(truck: str, time: float, tries: int, lasting: float = WINDOW) -> PushTerm:
    """Return the candidate of a push.

    Args:
        truck: Truck that is pushed.
        time: When it begins [s].
        tries: Windows, or stretches of them, among which it was looked for.
        lasting: How long it lasts [s].
    """
    axes = np.diag(SHOVE).tolist()
    probes = tuple(Push(truck, time, lasting, (axis[0], axis[1], axis[2])) for axis in axes)
    odds = BELIEFS["unknown"].log_odds - math.log(tries)
    fixed = {"times": (time,), "lasting": lasting, "quantity": MOMENTS, "acts_on": ""}
    return PushTerm("unknown", truck, probes, fixed, odds, positive=False)
