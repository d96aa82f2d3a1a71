"""Pushes: short displacements of a truck that are no obstacle under one wheel.

Somebody leans against the robot, a slider comes free, a cable pulls: the truck is displaced and turned by any
amount within a short time. A push is the rival of every event in the library.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import truck_number
from omnimate.effects.effect import TRUCK, Effect
from omnimate.mismatch.candidates.terms import UNKNOWN, Term, Unknown
from omnimate.mismatch.recording.signals import WINDOW

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Parameter, Stage
    from omnimate.vehicle.se2 import Array

PUSH_SIZE = np.array([3e-3, 3e-3, 1e-2])  # [m, m, rad] forward, left, yaw: prior standard deviation
PUSH_PART = 3 * WINDOW  # [s] of a longer push, within which its pace is constant
# Share of it by which any robot is pushed: 0.3 mm and 1 mrad, a quarter of a degree of play on a 15 cm wheel.
ORDINARY_PUSH = 0.1
PUSH_REGIME = "single moments"


@dataclass(frozen=True, slots=True)
class Push(Effect):
    """A truck is displaced and turned within some time."""

    time: float = 0.0  # when it begins [s]
    lasting: float = WINDOW  # how long it lasts [s]
    moved: tuple[tuple[float, float, float], ...] = ()  # in equal parts: forward, left [m], turn [rad]

    name: ClassVar[str] = UNKNOWN
    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK
    parameters: ClassVar[tuple[Parameter, ...]] = ()

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Push at an even pace in each part."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        edges = self.time + np.linspace(0.0, self.lasting, len(self.moved) + 1)
        for moved, begin, end in zip(self.moved, edges[:-1], edges[1:], strict=True):
            inside = slice(*np.searchsorted(block.time, (begin, end), side="right"))
            twist[inside] += (block.period[inside] / (end - begin))[:, None] * np.array(moved)
        return block.with_twist(truck, twist), state

    def acts_during(self, block: Block) -> tuple[float, float] | None:  # noqa: ARG002  its time is known
        """Return from when to when the truck is pushed [s]."""
        return self.time, self.time + self.lasting


@dataclass(frozen=True, slots=True)
class PushTerm(Term):
    """A push as a candidate of three columns for each of its parts."""

    def built(self, coefficients: Array) -> Push:
        """Return the push with these coefficients `(3 P,)` of its P parts."""
        parts = (coefficients.reshape(-1, 3) * PUSH_SIZE).tolist()
        moved = tuple((ahead, aside, yaw) for ahead, aside, yaw in parts)
        return Push(self.component, self.fixed["times"][0], self.fixed["lasting"], moved)

    @property
    def nuisance_size(self) -> float:
        """Plays, grains and seams push any robot by some tenths of a millimetre."""
        return ORDINARY_PUSH / math.sqrt(len(self.probes) / 3)

    @property
    def largest(self) -> float:
        """A truck may be pushed anywhere."""
        return math.inf

    @property
    def discrepancy(self) -> float:
        """No law says how a truck is pushed: what else is seen meanwhile says nothing of other effects."""
        return 1.0

    @property
    def stretches(self) -> list[tuple[float, float]]:
        """From when to when it acts [s]."""
        return [(time, time + self.fixed["lasting"]) for time in self.fixed["times"]]


def push(truck: str, time: float, tries: int, lasting: float = WINDOW) -> PushTerm:
    """Return a truck's push that begins at a time [s] and lasts [s], looked for among so many tries."""
    parts = max(1, round(lasting / PUSH_PART))
    axes = np.eye(3 * parts).reshape(-1, parts, 3) * PUSH_SIZE
    probes = tuple(
        Push(truck, time, lasting, tuple((ahead, aside, yaw) for ahead, aside, yaw in axis))
        for axis in axes.tolist()
    )
    odds = Unknown.prior.log_odds - math.log(tries)
    fixed = {"times": (time,), "lasting": lasting, "quantity": PUSH_REGIME, "acts_on": ""}
    return PushTerm(UNKNOWN, truck, probes, fixed, odds, positive=False)
